// Which of n things a loop has already come to, for loops that come to few of many.
#pragma once

#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface {

/// Allocates nothing while n does not grow.
class Marks {
 public:
  /// None of n things is taken. O(things that were taken).
  void begin(Index n) {
    for (const Index i : taken_) is_taken_[i] = 0;
    taken_.clear();
    if (n <= static_cast<Index>(is_taken_.size())) return;
    is_taken_.resize(n, 0);
    taken_.reserve(n);
  }
  /// Whether it was not taken before.
  bool take(Index i) {
    if (is_taken_[i]) return false;
    is_taken_[i] = 1;
    taken_.push_back(i);
    return true;
  }

 private:
  std::vector<char> is_taken_;
  std::vector<Index> taken_;
};

}  // namespace deformable_surface
