// Which neighbours of a point may be linked to it along the surface, and where they lie on its tangent plane. Rings, boundary and
// simplification must get the same answer.
#pragma once

#include "deformable_surface/base/types.h"

#include <algorithm>
#include <utility>

namespace deformable_surface::cloud {

/// Right-handed axes of the tangent plane: e1 x e2 is the normal. [Duff et al. 2017]
class TangentPlane {
 public:
  /// normal: unit.
  TangentPlane(const Vec3& origin, const Vec3& normal);

  Vec2 project(const Vec3& point) const {
    const Vec3 d = point - origin_;
    return Vec2(d.dot(e1_), d.dot(e2_));
  }

 private:
  Vec3 origin_, e1_, e2_;
};

/// Sine of the steepest slope of a link against a tangent plane, 60 degrees: a right-angled crease has links of 45 degrees. A
/// steeper link projects to less than half its length, so close to the point that it would push true neighbours out of the ring.
constexpr double kMaxSlope = 0.8660254;

/// False if the link is too steep for the tangent plane of either end. normal_i, normal_j: unit.
inline bool isFlat(const Vec3& link, const Vec3& normal_i, const Vec3& normal_j) {
  const double limit = kMaxSlope * kMaxSlope * link.squaredNorm();
  const double height_i = link.dot(normal_i), height_j = link.dot(normal_j);
  return height_i * height_i <= limit && height_j * height_j <= limit;
}

/// Separates links along the surface from mere closeness in space. Symmetric in the points. Keeps references to its arguments.
class LinkRule {
 public:
  /// neighbors: nearest first.
  LinkRule(const Points& positions, const Points& normals, const Lists& neighbors);

  /// False if the link is far longer than the local spacing at either end, or not flat.
  bool accepts(Index i, Index j) const {
    const Vec3 link = positions_[j] - positions_[i];
    return link.squaredNorm() <= maxSquaredLength(i, j) && isFlat(link, normals_[i], normals_[j]);
  }

  /// m^2, of a link between these points.
  double maxSquaredLength(Index i, Index j) const { return std::min(max_squared_length_[i], max_squared_length_[j]); }

 private:
  const Points& positions_;
  const Points& normals_;
  std::vector<double> max_squared_length_;  // (n) m^2
};

/// Connected components of any lists of links, symmetric or not: (n) numbered from 0 in the order of the smallest index.
std::vector<Index> labelComponents(const Lists& links, Index& num_components);
/// The same for links between n points that are given as pairs.
std::vector<Index> labelComponents(Index n, const std::vector<std::pair<Index, Index>>& links, Index& num_components);

}  // namespace deformable_surface::cloud
