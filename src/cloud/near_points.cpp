#include "deformable_surface/cloud/near_points.h"

#include "deformable_surface/base/hash.h"
#include "deformable_surface/base/median.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>

namespace deformable_surface::cloud {
namespace {

constexpr double kSame = 1e-6;       // of the spacing: what is nearer is one point, however many there are
constexpr double kAlmost = 1e-2;     // of the spacing around: what is nearer is almost the same point
constexpr Index kAsked = 16;         // neighbours: also where every point is there up to eight times
constexpr Index kMostSampled = 500;  // points of which the median is taken
constexpr Index kBlock = 1024;       // points per task

// Of the position alone, so that the order of the points does not choose the sample.
std::uint64_t hashOf(const Vec3& p) {
  std::uint64_t hash = kHashBegin;
  for (int axis = 0; axis < 3; ++axis) {
    std::uint64_t bits;
    const double x = p[axis] + 0.0;  // -0 is 0
    std::memcpy(&bits, &x, sizeof bits);
    hash = mixHash(hash, bits);
  }
  return hash;
}

// The distance from a point to the nearest one that is not almost the same; 0 if there is none. near: for reuse.
double findSpacing(const KdTree& tree, const Vec3& p, std::vector<Neighbor>& near) {
  tree.nearest(p, kAsked + 1, near);
  if (near.size() < 2) return 0.0;
  const double least = kAlmost * kAlmost * near.back().squared_distance;
  const auto next = std::find_if(near.begin() + 1, near.end(), [&](const Neighbor& j) { return j.squared_distance >= least; });
  return std::sqrt(next->squared_distance);
}

double findTypicalSpacing(const KdTree& tree, const Points& points) {
  const Index n = static_cast<Index>(points.size());
  const std::uint64_t stride = static_cast<std::uint64_t>(std::max(Index{1}, n / kMostSampled));
  std::vector<double> spacings;
  std::vector<Neighbor> near;
  for (const Vec3& p : points)
    if (stride == 1 || hashOf(p) % stride == 0) spacings.push_back(findSpacing(tree, p, near));
  return spacings.empty() ? 0.0 : findMedian(std::move(spacings));
}

// For each point the nearest other one, if it is almost the same; else -1. spacing: m, of a typical point. Where all points are
// near to each other the cloud is finer there.
std::vector<Index> findAlmostSame(const KdTree& tree, const Points& points, double spacing) {
  const Index n = static_cast<Index>(points.size());
  std::vector<Index> same(n, -1);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<Neighbor> near;
    for (Index k = begin; k < end; ++k) {
      const Index i = tree.order()[k];
      tree.nearest(points[i], 2, near, kAlmost * spacing);
      if (near.size() < 2) continue;
      const Neighbor j = near[near[0].index == i ? 1 : 0];
      const double distance = std::sqrt(j.squared_distance);
      if (distance <= kSame * spacing ||
          distance <= kAlmost * std::min(findSpacing(tree, points[i], near), findSpacing(tree, points[j.index], near)))
        same[i] = j.index;
    }
  });
  return same;
}

Index findFirst(std::vector<Index>& first_of, Index i) {
  while (first_of[i] != i) i = first_of[i] = first_of[first_of[i]];
  return i;
}

bool isLess(const Vec3& a, const Vec3& b) { return std::make_tuple(a.x(), a.y(), a.z()) < std::make_tuple(b.x(), b.y(), b.z()); }

// Joins each point with its nearest one. new_index: (of the points before, by point) where they are now.
void joinWithNearest(const std::vector<Index>& nearest, CleanCloud& cloud, std::vector<Index>& new_index) {
  const Index n = static_cast<Index>(cloud.positions.size());
  std::vector<Index> first_of(n);
  for (Index i = 0; i < n; ++i) first_of[i] = i;
  for (Index i = 0; i < n; ++i) {
    if (nearest[i] < 0) continue;
    const Index a = findFirst(first_of, i), b = findFirst(first_of, nearest[i]);
    first_of[std::max(a, b)] = std::min(a, b);
  }
  // The first of a group comes before the others.
  const bool has_normals = !cloud.normals.empty();
  new_index.assign(n, -1);
  Index m = 0;
  for (Index i = 0; i < n; ++i) {
    const Index first = findFirst(first_of, i);
    const Vec3 position = cloud.positions[i];
    if (first == i) {
      new_index[i] = m;
      cloud.positions[m] = position;
      if (has_normals) cloud.normals[m] = Vec3(cloud.normals[i]);
      ++m;
      continue;
    }
    const Index at = new_index[i] = new_index[first];
    if (isLess(position, cloud.positions[at])) cloud.positions[at] = position;
    if (has_normals && cloud.normals[at].isZero(0.0)) cloud.normals[at] = Vec3(cloud.normals[i]);
  }
  cloud.positions.resize(m);
  if (has_normals) cloud.normals.resize(m);
}

}  // namespace

double findTypicalSpacing(const Points& points) {
  if (points.size() < 2) return 0.0;
  return findTypicalSpacing(KdTree(points), points);
}

NearPoints mergeNearPoints(CleanCloud& cloud) {
  NearPoints result;
  const Index n = static_cast<Index>(cloud.positions.size());
  if (n < 2) return result;
  Points before;
  std::vector<Index> place;  // (n) where each point is now; empty: where it was
  for (;;) {
    cloud.tree = std::make_shared<KdTree>(cloud.positions);
    if (place.empty()) result.spacing = findTypicalSpacing(*cloud.tree, cloud.positions);
    const std::vector<Index> nearest = findAlmostSame(*cloud.tree, cloud.positions, result.spacing);
    if (std::all_of(nearest.begin(), nearest.end(), [](Index j) { return j < 0; })) break;
    if (place.empty()) {
      before = cloud.positions;
      place.resize(n);
      for (Index i = 0; i < n; ++i) place[i] = i;
    }
    // Groups join with groups until all are far from each other.
    std::vector<Index> new_index;
    joinWithNearest(nearest, cloud, new_index);
    for (Index& i : place) i = new_index[i];
  }
  if (place.empty()) return {};
  result.num_merged = n - static_cast<Index>(cloud.positions.size());
  for (Index i = 0; i < n; ++i) result.distance = std::max(result.distance, (before[i] - cloud.positions[place[i]]).norm());
  for (Index& point : cloud.point_of_input)
    if (point >= 0) point = place[point];
  return result;
}

}  // namespace deformable_surface::cloud
