// The rule for links: length against the spacing at both ends, slope against both tangent planes.
#include "deformable_surface/cloud/links.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace deformable_surface::cloud {
namespace {

// A Delaunay link of an even sampling is up to about twice the spacing; this leaves as much again for density that changes along
// the surface, and is well below the distance of what one would call a separate part.
constexpr double kMaxLinkRatio = 4.0;

// The spacing is the distance of the neighbour that completes a hexagon: unlike the nearest one it is not moved by a close pair.
constexpr Index kSpacingNeighbor = 6;

}  // namespace

TangentPlane::TangentPlane(const Vec3& origin, const Vec3& normal) : origin_(origin) {
  const double sign = std::copysign(1.0, normal.z());
  const double a = -1.0 / (sign + normal.z()), b = normal.x() * normal.y() * a;
  e1_ = Vec3(1.0 + sign * normal.x() * normal.x() * a, sign * b, -sign * normal.x());
  e2_ = Vec3(b, sign + normal.y() * normal.y() * a, -normal.y());
}

LinkRule::LinkRule(const Points& positions, const Points& normals, const Lists& neighbors)
    : positions_(positions), normals_(normals), max_squared_length_(positions.size(), 0.0) {
  for (Index i = 0; i < neighbors.size(); ++i) {
    const Index count = std::min(neighbors.count(i), kSpacingNeighbor);
    if (count == 0) continue;
    const double squared_spacing = (positions[neighbors.begin(i)[count - 1]] - positions[i]).squaredNorm();
    max_squared_length_[i] = kMaxLinkRatio * kMaxLinkRatio * squared_spacing;
  }
}

std::vector<Index> labelComponents(const Lists& links, Index& num_components) {
  // Union-find in which the smallest index of a set is its root.
  const Index n = links.size();
  std::vector<Index> parent(n);
  std::iota(parent.begin(), parent.end(), 0);
  const auto findRoot = [&](Index i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (Index i = 0; i < n; ++i) {
    for (const Index* j = links.begin(i); j != links.end(i); ++j) {
      const Index a = findRoot(i), b = findRoot(*j);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  num_components = 0;
  std::vector<Index> label(n);
  for (Index i = 0; i < n; ++i) label[i] = parent[i] == i ? num_components++ : label[findRoot(i)];
  return label;
}

}  // namespace deformable_surface::cloud
