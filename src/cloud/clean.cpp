// Removes points that cannot be simulated: points that are not finite and points on top of others.
#include "deformable_surface/cloud/clean.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel_sort.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace deformable_surface::cloud {
namespace {

// The unit vector along v, or zero if v has no direction.
Vec3 normalizeOrZero(const Vec3& v) {
  const double largest = v.cwiseAbs().maxCoeff();
  if (!v.allFinite() || !(largest > 0.0)) return Vec3::Zero();
  return (v / largest).normalized();
}

}  // namespace

CleanCloud clean(const PointCloud& input, double max_coordinate) {
  const Index n = input.size();
  if (!(max_coordinate > 0.0)) {
    throw InputError("clean: largest coordinate: found " + formatShort(max_coordinate) + " m; accepted: above 0");
  }
  if (!input.normals.empty() && input.normals.size() != input.positions.size()) {
    throw InputError("clean: found " + std::to_string(input.normals.size()) + " normals for " + std::to_string(n) +
                     " points; accepted: one for each, or none");
  }
  CleanCloud result;
  result.point_of_input.assign(n, -1);

  // Equal positions come together when sorted (-0 compares equal to 0), the first in the input leading. Hashing would be faster,
  // but a hostile cloud can make all its points collide.
  struct Entry {
    double x, y, z;
    Index input;
    bool operator<(const Entry& other) const {
      return std::tie(x, y, z, input) < std::tie(other.x, other.y, other.z, other.input);
    }
    bool coincides(const Entry& other) const { return x == other.x && y == other.y && z == other.z; }
  };
  std::vector<Entry> sorted;
  sorted.reserve(n);
  for (Index i = 0; i < n; ++i) {
    const Vec3& p = input.positions[i];
    if (p.allFinite() && p.cwiseAbs().maxCoeff() <= max_coordinate) {
      sorted.push_back({p.x(), p.y(), p.z(), i});
    } else {
      ++result.num_not_finite;
    }
  }
  parallelSort(sorted);
  std::vector<Index> first_of_input(n, -1);
  for (std::size_t s = 0; s < sorted.size(); ++s) {
    const bool repeats = s > 0 && sorted[s].coincides(sorted[s - 1]);
    first_of_input[sorted[s].input] = repeats ? first_of_input[sorted[s - 1].input] : sorted[s].input;
    if (repeats) ++result.num_coincident;
  }

  // Number the first ones in the order of the input; a later one gives its normal if the first has none.
  const Index m = static_cast<Index>(sorted.size()) - result.num_coincident;
  result.positions.reserve(m);
  if (!input.normals.empty()) result.normals.reserve(m);
  for (Index i = 0; i < n; ++i) {
    const Index first = first_of_input[i];
    if (first < 0) continue;
    if (first == i) {
      result.point_of_input[i] = static_cast<Index>(result.positions.size());
      result.positions.push_back(input.positions[i]);
      if (!input.normals.empty()) result.normals.push_back(normalizeOrZero(input.normals[i]));
    } else {
      const Index point = result.point_of_input[i] = result.point_of_input[first];
      if (!input.normals.empty() && result.normals[point].isZero(0.0)) result.normals[point] = normalizeOrZero(input.normals[i]);
    }
  }
  return result;
}

std::shared_ptr<const KdTree> findTree(const CleanCloud& cloud) {
  if (cloud.tree && cloud.tree->holds(cloud.positions)) return cloud.tree;
  return std::make_shared<KdTree>(cloud.positions);
}

}  // namespace deformable_surface::cloud
