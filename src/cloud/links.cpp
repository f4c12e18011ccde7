// The rule for links: length against the spacing at both ends, slope against both tangent planes.
#include "deformable_surface/cloud/links.h"

#include "deformable_surface/base/disjoint_sets.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::cloud {
namespace {

// A Delaunay link of an even sampling is up to about twice the spacing; the same again is allowed for a varying density along
// the surface. This is well below the distance of separate parts.
constexpr double kMaxLinkRatio = 4.0;

// The spacing is the distance of the neighbour that completes a hexagon: a close pair changes the nearest distance, not this one.
constexpr Index kSpacingNeighbor = 6;

constexpr Index kBlock = 4096;  // points per task: less than a millisecond of work

}  // namespace

TangentPlane::TangentPlane(const Vec3& origin, const Vec3& normal) : origin_(origin) {
  const double sign = std::copysign(1.0, normal.z());
  const double a = -1.0 / (sign + normal.z()), b = normal.x() * normal.y() * a;
  e1_ = Vec3(1.0 + sign * normal.x() * normal.x() * a, sign * b, -sign * normal.x());
  e2_ = Vec3(b, sign + normal.y() * normal.y() * a, -normal.y());
}

LinkRule::LinkRule(const Points& positions, const Points& normals, const Lists& neighbors)
    : positions_(positions), normals_(normals), max_squared_length_(positions.size(), 0.0) {
  parallelFor(neighbors.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Index count = std::min(neighbors.count(i), kSpacingNeighbor);
      if (count == 0) continue;
      const double squared_spacing = (positions[neighbors.begin(i)[count - 1]] - positions[i]).squaredNorm();
      max_squared_length_[i] = kMaxLinkRatio * kMaxLinkRatio * squared_spacing;
    }
  });
}

std::vector<Index> labelComponents(const Lists& links, Index& num_components) {
  std::vector<Index> parents;
  makeSingleSets(links.size(), parents);
  for (Index i = 0; i < links.size(); ++i)
    for (const Index* j = links.begin(i); j != links.end(i); ++j) joinSets(parents, i, *j);
  return labelSets(parents, num_components);
}

std::vector<Index> labelComponents(Index n, const std::vector<std::pair<Index, Index>>& links, Index& num_components) {
  std::vector<Index> parents;
  makeSingleSets(n, parents);
  for (const auto& [i, j] : links) joinSets(parents, i, j);
  return labelSets(parents, num_components);
}

}  // namespace deformable_surface::cloud
