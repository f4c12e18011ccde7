// A predicted motion of points, and how to check that they come as predicted.
#pragma once

#include "deformable_surface/base/types.h"

#include <cstddef>

namespace deformable_surface::contact {

/// A motion at constant velocities, and by how much each coordinate may leave it. A displacement that is common to all points
/// does not count: it brings nothing nearer.
struct ClearMotion {
  Points from, way;                                 // (n x 3) m: where it begins, and to its end
  Index leader = 0;                                 // the point that moves farthest: shows how much of the motion is done
  double tolerance = -1.0, apart_tolerance = -1.0;  // m, until something may cross, or be near; negative: not proven

  /// For points that keep their velocities (n) for a time; m and s, or any other unit of time. Allocates only for more points
  /// than ever before.
  void predict(const Points& positions, const Points& velocities, double time);
  /// The same for points that stay.
  void rest(const Points& positions);
  /// The share of the motion that is done where the leader is at a place.
  double shareAt(const Vec3& of_leader) const;
  /// Whether the points are within a tolerance (m) of the prediction. Undefined numbers are not.
  bool isNear(const Points& positions, double tolerance) const;
  /// The same, and later, after points have kept their velocities for a time.
  bool isNear(const Points& positions, const Points& velocities, double time, double tolerance) const;
  /// Upper bound, m, of how far any two points have left it in different directions; infinite for undefined numbers.
  double boundAside(const Points& positions) const;
  std::size_t bytes() const { return sizeof(ClearMotion) + (from.size() + way.size()) * sizeof(Vec3); }
};

}  // namespace deformable_surface::contact
