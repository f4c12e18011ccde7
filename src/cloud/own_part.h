// Which of the points around a point belong to its own layer: those that no gap separates from it. Private.
#pragma once

#include "deformable_surface/base/types.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace deformable_surface::cloud {

// The neighbours of a point that no gap parts from it: its component of their minimum spanning tree without the links
// that are much longer than most.
class OwnPart {
 public:
  // Nearest in the tree first; empty if that is all of them, none, or a row of points. Valid until the next call.
  const std::vector<Index>& find(const Points& positions, Index i, const Index* first, const Index* last) {
    outside_.clear();
    for (const Index* j = first; j != last; ++j) outside_.push_back({positions[*j], std::numeric_limits<double>::infinity(), *j});
    inside_.clear();
    links_.clear();
    Vec3 newest = positions[i];
    while (!outside_.empty()) {
      Candidate* next = outside_.data();
      for (Candidate& c : outside_) {
        c.squared = std::min(c.squared, (c.position - newest).squaredNorm());
        if (c.squared < next->squared) next = &c;
      }
      newest = next->position;
      inside_.push_back(next->point);
      links_.push_back(next->squared);
      *next = outside_.back();
      outside_.pop_back();
    }
    if (links_.empty()) return inside_;
    sorted_ = links_;
    const auto typical = sorted_.begin() + static_cast<std::ptrdiff_t>(kTreeQuantile * (sorted_.size() - 1));
    std::nth_element(sorted_.begin(), typical, sorted_.end());
    // The tree grows from the point: what comes before the first long link is its component.
    const auto gap = std::find_if(links_.begin(), links_.end(), [&](double s) { return s > kGap * kGap * *typical; });
    inside_.resize(gap == links_.end() ? 0 : gap - links_.begin());
    if (isCurve(positions, kNear * kNear * *typical)) inside_.clear();
    return inside_;
  }

 private:
  // A link that is longer than most (this quantile) by this factor is a gap.
  static constexpr double kTreeQuantile = 0.9, kGap = 1.3;
  // A point of a surface has on average at least so many points of its own part within kNear typical links; one of a row has two.
  static constexpr std::size_t kOfSurface = 3;
  static constexpr double kNear = 1.5;

  // A row of points, straight or bent: each has one neighbour on either side. Rows that lie far apart are one surface.
  bool isCurve(const Points& positions, double squared_near) const {
    std::size_t near = 0;
    for (const Index a : inside_)
      for (const Index b : inside_) near += a != b && (positions[a] - positions[b]).squaredNorm() < squared_near;
    return near < kOfSurface * inside_.size();
  }

  struct Candidate {
    Vec3 position;
    double squared;  // m^2, distance to the tree
    Index point;
  };
  std::vector<Candidate> outside_;
  std::vector<Index> inside_;
  std::vector<double> links_, sorted_;  // m^2, with which those inside joined the tree
};

}  // namespace deformable_surface::cloud
