#include "deformable_surface/model/mass_spring/triangle_membrane.h"

#include <algorithm>

#include "triangle_polar.h"

namespace deformable_surface::model {

TriangleMembrane::TriangleMembrane(const std::vector<WeightedTriangle>& triangles, const Points& rest, double membrane_stiffness,
                                   double poisson_ratio, const TriangleMembrane* whole)
    : mu_(membrane_stiffness / (2.0 * (1.0 + poisson_ratio))),
      lambda_(membrane_stiffness * poisson_ratio / (1.0 - poisson_ratio * poisson_ratio)) {
  for (const WeightedTriangle& t : triangles) {
    const Vec3 a = rest[t.corner[1]] - rest[t.corner[0]], b = rest[t.corner[2]] - rest[t.corner[0]];
    const double twice_area = a.cross(b).norm();
    if (!(twice_area > 0.0)) continue;
    // Edges in the triangle's own plane, first axis along a.
    const double length = a.norm();
    Mat2 edges;
    edges << length, a.dot(b) / length, 0.0, twice_area / length;
    Element e{{t.corner[0], t.corner[1], t.corner[2]}, edges.inverse(), 0.5 * t.weight * twice_area};
    if (e.inverse.allFinite()) elements_.push_back(e);
  }
  if (whole)
    takePatches(*whole);
  else
    groupTriangles();
  prepareForceLoop(static_cast<Index>(rest.size()));
}

Mat32 TriangleMembrane::gradient(const Element& e, const State& state) {
  const Vec3& origin = state.positions[e.corner[0]];
  Mat32 edges;
  edges << state.positions[e.corner[1]] - origin, state.positions[e.corner[2]] - origin;
  return edges * e.inverse;
}

std::vector<std::pair<Index, Index>> TriangleMembrane::findEdges() const {
  std::vector<std::pair<Index, Index>> edges;
  edges.reserve(3 * elements_.size());
  for (const Element& e : elements_)
    for (int c = 0; c < 3; ++c) edges.push_back(std::minmax({e.corner[c], e.corner[(c + 1) % 3]}));
  return edges;
}

}  // namespace deformable_surface::model
