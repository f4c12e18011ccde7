// Collects the nearest neighbours during a search. The search in a tree and the search in an image share it. Private.
#pragma once

#include "deformable_surface/cloud/kd_tree.h"

#include <limits>
#include <vector>

namespace deformable_surface::cloud {

/// The k smallest neighbours seen so far, sorted. For a few dozen neighbours insertion is faster than a heap.
class KNearest {
 public:
  /// squared_reach: m^2, of the farthest neighbour that counts.
  KNearest(Index k, std::vector<Neighbor>& out, double squared_reach = std::numeric_limits<double>::infinity())
      : k_(static_cast<std::size_t>(k)), out_(out), bound_(squared_reach) {
    out_.clear();
  }

  double bound() const { return bound_; }

  void add(double squared_distance, Index index) {
    const Neighbor candidate{squared_distance, index};
    if (out_.size() == k_) {
      if (!(candidate < out_.back())) return;
    } else {
      out_.emplace_back();
    }
    // By distance alone first: ties are rare, and a comparison of both takes twice the time.
    std::size_t at = out_.size() - 1;
    for (; at > 0 && squared_distance < out_[at - 1].squared_distance; --at) out_[at] = out_[at - 1];
    for (; at > 0 && candidate < out_[at - 1]; --at) out_[at] = out_[at - 1];
    out_[at] = candidate;
    if (out_.size() == k_) bound_ = out_.back().squared_distance;
  }

 private:
  std::size_t k_;
  std::vector<Neighbor>& out_;
  double bound_;
};

}  // namespace deformable_surface::cloud
