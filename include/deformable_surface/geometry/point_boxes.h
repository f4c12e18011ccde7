// Boxes around runs of points, and around all of them: what is far from a ball is skipped a run at a time.
#pragma once

#include "deformable_surface/base/types.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace deformable_surface::geometry {

/// Points that are near in space should be near in the list. The order decides only what is skipped.
class PointBoxes {
 public:
  static constexpr Index kRun = 32;  // points

  /// positions: (n x 3) m. Allocates nothing if there were as many before.
  void update(const Points& positions) {
    const Index n = static_cast<Index>(positions.size());
    boxes_.resize((n + kRun - 1) / kRun);
    all_.setEmpty();
    for (std::size_t r = 0; r < boxes_.size(); ++r) {
      const Index begin = static_cast<Index>(r) * kRun, end = std::min(n, begin + kRun);
      Vec3 low = positions[begin], high = low;
      for (Index i = begin + 1; i < end; ++i) {
        low = low.cwiseMin(positions[i]);
        high = high.cwiseMax(positions[i]);
      }
      boxes_[r] = {low, high};
      all_.extend(boxes_[r]);
    }
  }

  /// Whether a ball may hold any of the points. radius: m, may be infinite.
  bool mayMeet(const Vec3& centre, double radius) const { return meets(all_, centre, radius); }
  /// The same for the points kRun * run and up, as many as kRun.
  bool mayMeet(Index run, const Vec3& centre, double radius) const { return meets(boxes_[run], centre, radius); }

 private:
  using Box = Eigen::AlignedBox3d;  // m
  static constexpr double kRounding = 1.0 + 1e-9;

  static bool meets(const Box& box, const Vec3& centre, double radius) {
    if (radius == std::numeric_limits<double>::infinity()) return true;
    return !(box.squaredExteriorDistance(centre) > kRounding * radius * radius);
  }

  std::vector<Box> boxes_;  // of the runs
  Box all_;
};

}  // namespace deformable_surface::geometry
