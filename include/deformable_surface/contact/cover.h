// Which patches of a surface are known to stay clear of each other.
#pragma once

#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface::contact {

/// The couples of patches that are proven to stay clear of each other.
class Cover {
 public:
  void clear(Index num_patches) {
    charts_.resize(num_patches);
    for (std::vector<Index>& charts : charts_) charts.clear();
    is_empty_ = true;
  }
  void add(const std::vector<Index>& patches, Index chart) {
    for (const Index p : patches) charts_[p].push_back(chart);
    is_empty_ = is_empty_ && patches.empty();
  }
  void end() { ++revision_; }

  bool isEmpty() const { return is_empty_; }
  /// Changes with the cover.
  Index revision() const { return revision_; }
  /// Whether a chart holds both.
  bool holds(Index one, Index other) const {
    for (const Index a : charts_[one])
      for (const Index b : charts_[other])
        if (a == b) return true;
    return false;
  }

 private:
  std::vector<std::vector<Index>> charts_;  // by patch
  bool is_empty_ = true;
  Index revision_ = 0;
};

}  // namespace deformable_surface::contact
