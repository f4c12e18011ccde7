#include "deformable_surface/base/block_sparse.h"

#include <algorithm>

namespace deformable_surface {

void BlockSparse::begin(Index n) {
  if (n != n_) {
    n_ = n;
    entries_.clear();
  }
  next_ = 0;
  replay_ = !entries_.empty();
  pending_.clear();
  for (Mat3& value : values_) value.setZero();
}

void BlockSparse::add(Index i, Index j, const Mat3& block) {
  if (replay_) {
    if (next_ < entries_.size() && entries_[next_].i == i && entries_[next_].j == j) {
      const Index slot = entries_[next_++].slot;
      if (i >= j) {
        values_[slot] += block;
      } else {
        values_[slot] += block.transpose();
      }
      return;
    }
    // Another order than last time: keep what was summed so far as one block per slot, and collect the rest.
    std::vector<Entry> summed;
    std::vector<char> seen(values_.size(), 0);
    for (std::size_t k = 0; k < next_; ++k) {
      Entry entry = entries_[k];
      if (seen[entry.slot]) continue;
      seen[entry.slot] = 1;
      pending_.push_back(values_[entry.slot]);
      if (entry.i < entry.j) std::swap(entry.i, entry.j);
      summed.push_back(entry);
    }
    entries_ = std::move(summed);
    replay_ = false;
  } else if (next_ == 0) {
    entries_.clear();
  }
  entries_.push_back({i, j, 0});
  pending_.push_back(block);
  next_ = entries_.size();
}

void BlockSparse::buildPattern() {
  // Number the distinct blocks of the lower triangle by (column, row).
  const auto key = [this](const Entry& e) {
    return static_cast<std::int64_t>(std::min(e.i, e.j)) * n_ + std::max(e.i, e.j);
  };
  std::vector<std::int64_t> keys;
  keys.reserve(entries_.size());
  for (const Entry& entry : entries_) keys.push_back(key(entry));
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  values_.assign(keys.size(), Mat3::Zero());
  for (std::size_t k = 0; k < entries_.size(); ++k) {
    Entry& entry = entries_[k];
    entry.slot = static_cast<Index>(std::lower_bound(keys.begin(), keys.end(), key(entry)) - keys.begin());
    if (entry.i >= entry.j) {
      values_[entry.slot] += pending_[k];
    } else {
      values_[entry.slot] += pending_[k].transpose();
    }
  }
  std::vector<Mat3>().swap(pending_);  // the largest array of all, needed once

  // The scalar matrix, and where each scalar of each block stands in it.
  std::vector<Eigen::Triplet<double, int>> triplets;
  triplets.reserve(9 * keys.size());
  for (std::int64_t k : keys) {
    const int column = static_cast<int>(3 * (k / n_)), row = static_cast<int>(3 * (k % n_));
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r)
        if (row + r >= column + c) triplets.emplace_back(row + r, column + c, 0.0);
  }
  matrix_.resize(3 * n_, 3 * n_);
  matrix_.setFromTriplets(triplets.begin(), triplets.end());
  value_position_.assign(9 * keys.size(), -1);
  for (std::size_t s = 0; s < keys.size(); ++s) {
    const int column = static_cast<int>(3 * (keys[s] / n_)), row = static_cast<int>(3 * (keys[s] % n_));
    for (int c = 0; c < 3; ++c) {
      const int* first = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column + c];
      const int* last = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column + c + 1];
      for (int r = 0; r < 3; ++r)
        if (row + r >= column + c)
          value_position_[9 * s + 3 * c + r] =
              static_cast<Index>(std::lower_bound(first, last, row + r) - matrix_.innerIndexPtr());
    }
  }
}

const Eigen::SparseMatrix<double>& BlockSparse::finish() {
  pattern_changed_ = !replay_;  // a pass with fewer blocks than last time keeps the pattern, with zeros in it
  if (!replay_) buildPattern();
  for (std::size_t s = 0; s < values_.size(); ++s)
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) {
        const Index position = value_position_[9 * s + 3 * c + r];
        if (position >= 0) matrix_.valuePtr()[position] = values_[s](r, c);
      }
  return matrix_;
}

}  // namespace deformable_surface
