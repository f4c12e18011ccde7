// The rule for links: length against the spacing at both ends, slope against both tangent planes.
#include "deformable_surface/cloud/links.h"

#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace deformable_surface::cloud {
namespace {

// A Delaunay link of an even sampling is up to about twice the spacing; the same again is allowed for a varying density along
// the surface. This is well below the distance of separate parts.
constexpr double kMaxLinkRatio = 4.0;

// The spacing is the distance of the neighbour that completes a hexagon: a close pair changes the nearest distance, not this one.
constexpr Index kSpacingNeighbor = 6;

constexpr Index kBlock = 4096;  // points per task: less than a millisecond of work

// Union-find in which the smallest index of a set is its root.
class Components {
 public:
  explicit Components(Index n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  void join(Index i, Index j) {
    const Index a = findRoot(i), b = findRoot(j);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  std::vector<Index> label(Index& num_components) {
    num_components = 0;
    std::vector<Index> label(parent_.size());
    for (Index i = 0; i < static_cast<Index>(parent_.size()); ++i)
      label[i] = parent_[i] == i ? num_components++ : label[findRoot(i)];
    return label;
  }

 private:
  Index findRoot(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  std::vector<Index> parent_;
};

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
  Components components(links.size());
  for (Index i = 0; i < links.size(); ++i)
    for (const Index* j = links.begin(i); j != links.end(i); ++j) components.join(i, *j);
  return components.label(num_components);
}

std::vector<Index> labelComponents(Index n, const std::vector<std::pair<Index, Index>>& links, Index& num_components) {
  Components components(n);
  for (const auto& [i, j] : links) components.join(i, j);
  return components.label(num_components);
}

}  // namespace deformable_surface::cloud
