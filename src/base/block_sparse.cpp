#include "deformable_surface/base/block_sparse.h"

#include <algorithm>
#include <utility>

namespace deformable_surface {

void BlockSparse::begin(Index n) {
  if (n != pattern_.size()) {
    pattern_.offsets.assign(n + 1, 0);
    pattern_.items.clear();
    values_.clear();
    order_.clear();
  }
  next_ = 0;
  pending_.clear();
  for (Mat3& value : values_) value.setZero();
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
    pending_.push_back({std::max(i, j), std::min(i, j), i >= j ? block : Mat3(block.transpose())});
  } else if (i >= j) {
    values_[entry.slot] += block;
  } else {
    values_[entry.slot] += block.transpose();
  }
}

bool BlockSparse::finish() {
  // A matrix that was never filled lacks its diagonal.
  if (pending_.empty() && static_cast<Index>(pattern_.items.size()) >= pattern_.size()) return false;
  buildPattern();
  return true;
}

// The blocks there were, those that wait and the diagonal, by column and row.
void BlockSparse::buildPattern() {
  const Index n = pattern_.size();
  std::vector<Index> next(n + 1, 0);
  for (const Pending& p : pending_) ++next[p.column + 1];
  for (Index column = 0; column < n; ++column) next[column + 1] += next[column];
  std::vector<Index> waiting(pending_.size());  // rows, by column; next[column] is where those of the next one begin
  for (const Pending& p : pending_) waiting[next[p.column]++] = p.row;

  const Lists before = std::exchange(pattern_, Lists());
  std::vector<Index> rows;
  for (Index column = 0; column < n; ++column) {
    rows.assign(1, column);
    rows.insert(rows.end(), before.begin(column), before.end(column));
    rows.insert(rows.end(), waiting.begin() + (column > 0 ? next[column - 1] : 0), waiting.begin() + next[column]);
    std::sort(rows.begin(), rows.end());
    pattern_.items.insert(pattern_.items.end(), rows.begin(), std::unique(rows.begin(), rows.end()));
    pattern_.offsets.push_back(static_cast<Index>(pattern_.items.size()));
  }
  const std::vector<Mat3> values_before = std::exchange(values_, std::vector<Mat3>(pattern_.items.size(), Mat3::Zero()));

  for (Index column = 0; column < n; ++column)
    for (Index k = before.offsets[column]; k < before.offsets[column + 1]; ++k)
      values_[find(before.items[k], column)] = values_before[k];
  for (const Pending& p : pending_) values_[find(p.row, p.column)] += p.block;
  for (Entry& entry : order_) entry.slot = find(entry.i, entry.j);
  std::vector<Pending>().swap(pending_);  // the largest array of all, seldom needed again
}

void BlockSparse::multiply(const Eigen::VectorXd& x, Eigen::VectorXd& product) const {
  product.setZero(x.size());
  for (Index column = 0; column < pattern_.size(); ++column) {
    Index k = pattern_.offsets[column];
    const Vec3 at_column = x.segment<3>(3 * column);
    Vec3 sum = values_[k++] * at_column;
    for (; k < pattern_.offsets[column + 1]; ++k) {
      const Index row = pattern_.items[k];
      product.segment<3>(3 * row) += values_[k] * at_column;
      sum += values_[k].transpose() * x.segment<3>(3 * row);
    }
    product.segment<3>(3 * column) += sum;
  }
}

}  // namespace deformable_surface
