#include "deformable_surface/cloud/space_order.h"

#include "deformable_surface/base/median.h"
#include "deformable_surface/base/parallel_sort.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace deformable_surface::cloud {
namespace {

// Fewer points fit in the caches in any order.
constexpr Index kFewest = 20000;
// Rows of a scan, leaves of a tree and tiles go from neighbour to neighbour; in a shuffled cloud steps are as long as the body.
// In spacings of a flat square of as many points.
constexpr double kLongestStep = 8.0;
// One step in kSampled is measured.
constexpr Index kSampled = 16;
constexpr int kBits = 21;  // of each axis: three times this in 64

Vec3 findLow(const Points& points) {
  Vec3 low = points.front();
  for (const Vec3& p : points) low = low.cwiseMin(p);
  return low;
}

double findExtent(const Points& points, const Vec3& low) {
  Vec3 high = low;
  for (const Vec3& p : points) high = high.cwiseMax(p);
  return (high - low).maxCoeff();
}

bool isScattered(const Points& points, double extent) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < points.size(); i += kSampled) steps.push_back((points[i] - points[i - 1]).norm());
  return findMedian(std::move(steps)) > kLongestStep * extent / std::sqrt(static_cast<double>(points.size()));
}

// The bits of a number of kBits bits, each followed by two zeros.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffffu;
  x = (x | x << 16) & 0x1f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

void reorder(const std::vector<std::pair<std::uint64_t, Index>>& order, Points& points) {
  if (points.empty()) return;
  Points sorted;
  sorted.reserve(points.size());
  for (const auto& entry : order) sorted.push_back(points[entry.second]);
  points = std::move(sorted);
}

}  // namespace

bool orderInSpace(CleanCloud& cloud) {
  const Index n = static_cast<Index>(cloud.positions.size());
  if (n < kFewest) return false;
  const Vec3 low = findLow(cloud.positions);
  const double extent = findExtent(cloud.positions, low);
  if (!isScattered(cloud.positions, extent)) return false;

  const double scale = ((std::int64_t{1} << kBits) - 1) / extent;
  std::vector<std::pair<std::uint64_t, Index>> order(n);  // place along the curve, point
  for (Index i = 0; i < n; ++i) {
    const Vec3 cell = (cloud.positions[i] - low) * scale;
    const auto spreadAxis = [&](int axis) { return spread(static_cast<std::uint64_t>(cell[axis])); };
    order[i] = {spreadAxis(0) | spreadAxis(1) << 1 | spreadAxis(2) << 2, i};
  }
  parallelSort(order);
  reorder(order, cloud.positions);
  reorder(order, cloud.normals);
  std::vector<Index> place(n);
  for (Index s = 0; s < n; ++s) place[order[s].second] = s;
  for (Index& point : cloud.point_of_input)
    if (point >= 0) point = place[point];
  return true;
}

}  // namespace deformable_surface::cloud
