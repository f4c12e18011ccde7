#include "deformable_surface/cloud/near_points.h"

#include "deformable_surface/base/hash.h"
#include "deformable_surface/base/median.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/parallel_sort.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>

namespace deformable_surface::cloud {
namespace {

constexpr double kSame = 1e-6;       // of the spacing: what is nearer is one point
constexpr double kAlmost = 1e-2;     // of the distance to the last asked neighbour: what is nearer is almost the same point
constexpr Index kAsked = 16;         // neighbours: also where every point is there up to eight times
constexpr Index kMostSampled = 500;  // points of which the median is taken
constexpr Index kBlock = 1024;       // points per task
// The spacing is at most this times the extent over the cube root of the number, also where every point is there eight times:
// spheres of half the spacing do not overlap.
constexpr double kMostSpacing = 5.0;
constexpr double kCell = 1e3;         // distances to look for, in a cell: few points are near the walls, few cells hold two
constexpr double kOffset = 0.37;      // cells, so that a coordinate that all points share is not at a wall
constexpr std::size_t kCrowded = 32;  // points in one cell
constexpr int kBits = 21;             // of each axis: three times this in 64

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

double findTypicalSpacing(const KdTree& tree, const Points& points) {
  const Index n = static_cast<Index>(points.size());
  const std::uint64_t stride = static_cast<std::uint64_t>(std::max(Index{1}, n / kMostSampled));
  std::vector<double> spacings;
  std::vector<Neighbor> near;
  for (const Vec3& p : points) {
    if (stride > 1 && hashOf(p) % stride != 0) continue;
    tree.nearest(p, kAsked + 1, near);
    if (near.size() < 2) continue;
    const double least = kAlmost * kAlmost * near.back().squared_distance;
    const auto next = std::find_if(near.begin() + 1, near.end(), [&](const Neighbor& j) { return j.squared_distance >= least; });
    spacings.push_back(std::sqrt(next->squared_distance));
  }
  return spacings.empty() ? 0.0 : findMedian(std::move(spacings));
}

// Whether two points may be nearer to each other than a distance: cheap, for the clouds without such. A point near the wall of a
// cell counts on both sides. A crowded cell is not searched.
bool mayHaveNear(const Points& points, const Vec3& low, double distance) {
  const double cell = kCell * distance, margin = 2.0 / kCell;
  std::vector<std::pair<std::uint64_t, Index>> entries;
  entries.reserve(points.size());
  for (Index i = 0; i < static_cast<Index>(points.size()); ++i) {
    const Vec3 u = (points[i] - low) / cell + Vec3::Constant(kOffset);
    std::uint64_t from[3], to[3];
    for (int axis = 0; axis < 3; ++axis) {
      from[axis] = static_cast<std::uint64_t>(std::max(0.0, u[axis] - margin));
      to[axis] = static_cast<std::uint64_t>(u[axis] + margin);
    }
    for (std::uint64_t x = from[0]; x <= to[0]; ++x)
      for (std::uint64_t y = from[1]; y <= to[1]; ++y)
        for (std::uint64_t z = from[2]; z <= to[2]; ++z) entries.emplace_back((x << kBits | y) << kBits | z, i);
  }
  parallelSort(entries);
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    while (end < entries.size() && entries[end].first == entries[begin].first) ++end;
    if (end - begin > kCrowded) return true;
    for (std::size_t a = begin; a < end; ++a)
      for (std::size_t b = a + 1; b < end; ++b)
        if ((points[entries[a].second] - points[entries[b].second]).squaredNorm() <= distance * distance) return true;
  }
  return false;
}

bool mayHaveNear(const Points& points) {
  Vec3 low = points.front(), high = low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double distance = kSame * kMostSpacing * (high - low).maxCoeff() / std::cbrt(static_cast<double>(points.size()));
  return distance > 0.0 && mayHaveNear(points, low, distance);
}

// For each point the nearest other one within the distance, -1: there is none.
std::vector<Index> findNearest(const KdTree& tree, const Points& points, double distance) {
  const Index n = static_cast<Index>(points.size());
  std::vector<Index> nearest(n, -1);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<Neighbor> near;
    for (Index k = begin; k < end; ++k) {
      const Index i = tree.order()[k];
      tree.nearest(points[i], 2, near);
      for (const Neighbor& j : near)
        if (j.index != i && j.squared_distance <= distance * distance) nearest[i] = j.index;
    }
  });
  return nearest;
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
  if (n < 2 || !mayHaveNear(cloud.positions)) return result;
  Points before;
  std::vector<Index> place;  // (n) where each point is now; empty: where it was
  for (;;) {
    const KdTree tree(cloud.positions);
    if (place.empty()) result.spacing = findTypicalSpacing(tree, cloud.positions);
    const std::vector<Index> nearest = findNearest(tree, cloud.positions, kSame * result.spacing);
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
  if (place.empty()) return result;
  result.num_merged = n - static_cast<Index>(cloud.positions.size());
  for (Index i = 0; i < n; ++i) result.distance = std::max(result.distance, (before[i] - cloud.positions[place[i]]).norm());
  for (Index& point : cloud.point_of_input)
    if (point >= 0) point = place[point];
  return result;
}

}  // namespace deformable_surface::cloud
