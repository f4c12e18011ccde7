// Which neighbours of a point may be linked to it over the surface, and where they lie on its tangent plane. Rings, boundary and
// simplification ask the same question and must get the same answer.
#pragma once

#include "deformable_surface/base/types.h"

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

/// Tells links over the surface from mere closeness in space. Symmetric in the two points. Keeps references to its arguments.
class LinkRule {
 public:
  /// neighbors: nearest first.
  LinkRule(const Points& positions, const Points& normals, const Lists& neighbors);

  /// False if the link is far longer than the local spacing at either end, or too steep for the tangent plane of either end.
  bool accepts(Index i, Index j) const;

  /// As accepts, without the length: for sets that have been thinned since the spacing was taken.
  bool isFlat(Index i, Index j) const;

 private:
  const Points& positions_;
  const Points& normals_;
  std::vector<double> max_squared_length_;  // (n) m^2
};

/// Connected components of any lists of links, symmetric or not: (n) numbered from 0 in the order of the smallest index.
std::vector<Index> labelComponents(const Lists& links, Index& num_components);

}  // namespace deformable_surface::cloud
