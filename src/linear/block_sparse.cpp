#include "deformable_surface/linear/block_sparse.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <utility>

namespace deformable_surface {
namespace {

constexpr Index kBlock = 64;         // rows per task: some microseconds of work
constexpr Index kCleared = 4096;     // blocks per task of clearing them: tens of microseconds
constexpr std::size_t kLook = 1024;  // blocks of a first filling between two looks at an interrupt

}  // namespace

void BlockSparse::begin(Index n) {
  if (n != pattern_.size()) {
    pattern_.offsets.assign(n + 1, 0);
    pattern_.items.clear();
    values_.clear();
    order_.clear();
  }
  next_ = 0;
  pending_.clear();
  parallelFor(static_cast<Index>(values_.size()), kCleared, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) values_[k].setZero();
  });
  named_.assign(values_.size(), 0);
}

Index BlockSparse::find(Index i, Index j) const {
  const Index column = std::min(i, j), row = std::max(i, j);
  const Index* place = std::lower_bound(pattern_.begin(column), pattern_.end(column), row);
  return place != pattern_.end(column) && *place == row ? static_cast<Index>(place - pattern_.items.data()) : -1;
}

void BlockSparse::add(Index i, Index j, const Mat3& block) {
  if (next_ == order_.size()) order_.push_back({-1, -1, -1});
  Entry& entry = order_[next_++];
  if (entry.i != i || entry.j != j || entry.slot < 0) entry = {i, j, find(i, j)};
  if (entry.slot < 0) {
    endIfInterrupted(pending_.size(), kLook);
    pending_.push_back({std::max(i, j), std::min(i, j), i >= j ? block : Mat3(block.transpose())});
    return;
  }
  named_[entry.slot] = 1;
  if (i >= j)
    values_[entry.slot] += block;
  else
    values_[entry.slot] += block.transpose();
}

bool BlockSparse::finish(bool exactly) {
  const Index n = pattern_.size();
  // A matrix that was never filled lacks its diagonal.
  bool is_known = pending_.empty() && static_cast<Index>(pattern_.items.size()) >= n;
  if (is_known && exactly) {
    for (Index column = 0; column < n; ++column) named_[pattern_.offsets[column]] = 1;
    is_known = std::find(named_.begin(), named_.end(), 0) == named_.end();
  }
  if (!is_known) buildPattern(exactly);
  return !is_known;
}

// The existing blocks, or those of them that were named, pending ones and the diagonal, by column and row. A first filling names
// each block many times, so that the cost per entry must be small.
void BlockSparse::buildPattern(bool exactly) {
  const Index n = pattern_.size();
  Lists waiting;  // of each column, in the order in which they came
  waiting.offsets.assign(n + 1, 0);
  for (const Pending& p : pending_) ++waiting.offsets[p.column + 1];
  for (Index column = 0; column < n; ++column) waiting.offsets[column + 1] += waiting.offsets[column];
  waiting.items.resize(pending_.size());
  std::vector<Index> next(waiting.offsets.begin(), waiting.offsets.end() - 1);
  for (std::size_t k = 0; k < pending_.size(); ++k) waiting.items[next[pending_[k].column]++] = static_cast<Index>(k);

  const Lists before = std::exchange(pattern_, Lists());
  const std::vector<Mat3> values_before = std::exchange(values_, {});
  const auto stays = [&](Index k) { return !exactly || named_[k] != 0; };
  std::vector<Index> moved(values_before.size(), -1), found(pending_.size());  // slots of existing and of pending blocks
  std::vector<Index> slot(n), seen(n, -1);                                     // of a row; the last column that it was seen in
  std::vector<Index> rows;
  pattern_.offsets.assign(1, 0);
  for (Index column = 0; column < n; ++column) {
    endIfInterrupted();  // begin() sees that the pattern has too few columns then
    rows.clear();
    const auto see = [&](Index row) {
      if (std::exchange(seen[row], column) != column) rows.push_back(row);
    };
    see(column);
    for (Index k = before.offsets[column]; k < before.offsets[column + 1]; ++k)
      if (stays(k)) see(before.items[k]);
    for (const Index* k = waiting.begin(column); k != waiting.end(column); ++k) see(pending_[*k].row);
    std::sort(rows.begin(), rows.end());
    for (const Index row : rows) {
      slot[row] = static_cast<Index>(pattern_.items.size());
      pattern_.items.push_back(row);
    }
    pattern_.offsets.push_back(static_cast<Index>(pattern_.items.size()));
    values_.resize(pattern_.items.size(), Mat3::Zero());
    for (Index k = before.offsets[column]; k < before.offsets[column + 1]; ++k)
      if (stays(k)) values_[moved[k] = slot[before.items[k]]] = values_before[k];
    for (const Index* k = waiting.begin(column); k != waiting.end(column); ++k)
      values_[found[*k] = slot[pending_[*k].row]] += pending_[*k].block;
  }
  auto next_found = found.begin();
  for (std::size_t k = 0; k < order_.size(); ++k) {
    Entry& entry = order_[k];
    if (entry.slot >= 0) {
      entry.slot = moved[entry.slot];
    } else if (k < next_) {  // entries after it are left of an abandoned filling
      entry.slot = *next_found++;
    }
  }
  listRows();
  named_.resize(values_.size());
  std::vector<Pending>().swap(pending_);  // the largest array of all, seldom needed again
}

// Of the rows left of the diagonal: which blocks they have, and in which columns.
void BlockSparse::listRows() {
  const Index n = pattern_.size();
  left_.offsets.assign(n + 1, 0);
  for (Index column = 0; column < n; ++column)
    for (const Index* row = pattern_.begin(column) + 1; row != pattern_.end(column); ++row) left_.offsets[*row + 1] += 2;
  for (Index row = 0; row < n; ++row) left_.offsets[row + 1] += left_.offsets[row];
  left_.items.resize(left_.offsets.back());
  std::vector<Index> next(left_.offsets.begin(), left_.offsets.end() - 1);
  for (Index column = 0; column < n; ++column)
    for (Index k = pattern_.offsets[column] + 1; k < pattern_.offsets[column + 1]; ++k) {
      Index& place = next[pattern_.items[k]];
      left_.items[place++] = k;
      left_.items[place++] = column;
    }
}

void BlockSparse::multiply(const Eigen::VectorXd& x, Eigen::VectorXd& product) const {
  product.resize(x.size());
  parallelFor(pattern_.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      Index k = pattern_.offsets[i];
      Vec3 sum = values_[k++] * x.segment<3>(3 * i);
      for (; k < pattern_.offsets[i + 1]; ++k) sum += values_[k].transpose() * x.segment<3>(3 * pattern_.items[k]);
      for (const Index* left = left_.begin(i); left != left_.end(i); left += 2)
        sum += values_[left[0]] * x.segment<3>(3 * left[1]);
      product.segment<3>(3 * i) = sum;
    }
  });
}

}  // namespace deformable_surface
