#include "wanted_spacing.h"

#include "deformable_surface/simulation/model_kind.h"

#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

#include "rest_parts.h"
#include "spacing.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Spacings at the edge of a small clamp and at a point load, over that far away: found by trials (docs/accuracy.md).
constexpr double kAtClamps = 0.7, kAtLoads = 0.4;
// Growth of the spacing, in units of its mean, on a path as long as the root of the area, if kWantedGrowth allows: bending at a
// clamp scales with the surface, not with the spacing. Inside pins paths count kInside times.
constexpr double kRate = 5.0, kInside = 2.5;
constexpr double kSmallPin = 0.25;   // of the root of the area: larger pins clamp along a line, without a concentration
constexpr Index kEdgeNeighbors = 6;  // of a point at the edge of a pin the pin holds some of its ring, and not all
constexpr int kHalvings = 60;        // of the interval in which the spacing far away is: down to rounding

// The diagonal of the box around the points that a pin holds, m.
double measureExtent(const Points& points, const PinParams& pin) {
  Vec3 low = Vec3::Constant(kInfinity), high = -low;
  for (const Vec3& p : points) {
    if (!pin.region.contains(p)) continue;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

// Marks (n) the points held by pins at whose edges bending is concentrated.
std::vector<char> findClamped(const SceneParams& params, const Points& dense, double area) {
  std::vector<char> clamped(dense.size(), 0);
  if (!findModel(params.model).isPlate(params)) return clamped;
  const double spacing = findSpacing(area, dense.size());
  for (const PinParams& pin : params.pins) {
    if (!isBandOfRows(dense, pin, spacing) || measureExtent(dense, pin) > kSmallPin * std::sqrt(area)) continue;
    for (std::size_t i = 0; i < dense.size(); ++i)
      if (pin.region.contains(dense[i])) clamped[i] = 1;
  }
  return clamped;
}

std::vector<Index> findEdge(const std::vector<char>& clamped, const Lists& neighbors) {
  std::vector<Index> edge;
  for (Index i = 0; i < neighbors.size(); ++i) {
    const Index* end = neighbors.begin(i) + std::min(kEdgeNeighbors, neighbors.count(i));
    if (std::any_of(neighbors.begin(i), end, [&](Index j) { return clamped[j] != clamped[i]; })) edge.push_back(i);
  }
  return edge;
}

// Lengths of the shortest paths over k neighbours from the nearest of these points (n), m; infinite beyond the limit.
std::vector<double> findDistances(const RestSurface& s, Index k, const std::vector<Index>& from, const std::vector<char>& clamped,
                                  double limit) {
  const Points& x = s.dense.positions;
  std::vector<double> distance(x.size(), kInfinity);
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;
  for (Index i : from) {
    distance[i] = 0.0;
    queue.push({0.0, i});
  }
  while (!queue.empty()) {
    const auto [length, i] = queue.top();
    queue.pop();
    if (length > distance[i]) continue;
    const Index* end = s.dense_neighbors.begin(i) + std::min(k, s.dense_neighbors.count(i));
    for (const Index* j = s.dense_neighbors.begin(i); j != end; ++j) {
      const double next = length + (clamped[*j] ? kInside : 1.0) * (x[*j] - x[i]).norm();
      if (!(next < distance[*j]) || next > limit) continue;
      distance[*j] = next;
      queue.push({next, *j});
    }
  }
  return distance;
}

// The area of each point, m^2: of the disc that holds its k nearest neighbours; half of it at a boundary.
std::vector<double> findShares(const RestSurface& s, Index k, const std::vector<char>& is_boundary) {
  const Points& x = s.dense.positions;
  std::vector<double> shares(x.size(), 0.0);
  for (Index i = 0; i < s.dense_neighbors.size(); ++i) {
    const Index count = std::min(k, s.dense_neighbors.count(i));
    if (count == 0) continue;
    const double squared_radius = (x[s.dense_neighbors.begin(i)[count - 1]] - x[i]).squaredNorm();
    shares[i] = (is_boundary[i] ? 0.5 : 1.0) * kPi * squared_radius / count;
  }
  return shares;
}

}  // namespace

Points findLoadedPlaces(const SceneParams& params) {
  Points places;
  for (const ForceParams& force : params.forces)
    if (force.radius == 0.0 && !force.force.isZero(0.0) && force.end > 0.0) places.push_back(force.point);
  for (const AnchorParams& anchor : params.anchors)
    if (anchor.stiffness > 0.0) places.push_back(anchor.point);
  return places;
}

std::vector<Index> chooseLoadedPoints(const SceneParams& params, const Points& dense) {
  const Points places = findLoadedPlaces(params);
  if (places.empty()) return {};
  const cloud::KdTree tree(dense);
  std::vector<cloud::Neighbor> nearest;
  std::vector<Index> loaded;
  for (const Vec3& place : places) {
    tree.nearest(place, 1, nearest);
    loaded.push_back(nearest[0].index);
  }
  std::sort(loaded.begin(), loaded.end());
  loaded.erase(std::unique(loaded.begin(), loaded.end()), loaded.end());
  return loaded;
}

double estimateArea(const RestSurface& s, Index k, const std::vector<char>& is_boundary) {
  const std::vector<double> shares = findShares(s, k, is_boundary);
  return std::accumulate(shares.begin(), shares.end(), 0.0);
}

std::vector<double> findWantedSpacing(const SceneParams& params, const std::vector<char>& is_boundary, Index target,
                                      const RestSurface& s) {
  const Points& x = s.dense.positions;
  const Index n = static_cast<Index>(x.size()), k = params.neighbors.k;
  const std::vector<double> shares = findShares(s, k, is_boundary);
  double area = 0.0;
  for (const double share : shares) area += share;
  const double spacing = findSpacing(area, std::max(target, Index{1}));
  const std::vector<char> clamped = findClamped(params, x, area);
  const std::vector<Index> edge = findEdge(clamped, s.dense_neighbors), loaded = chooseLoadedPoints(params, x);
  if (edge.empty() && loaded.empty()) return {};

  const double rate = std::min(kRate / std::sqrt(area), kWantedGrowth / spacing);  // 1/m
  const double limit = kCoarsestWanted / rate;
  const std::vector<double> to_edge = findDistances(s, k, edge, clamped, limit);
  const std::vector<double> to_load = findDistances(s, k, loaded, clamped, limit);
  const auto wantedAt = [&](Index i, double far) {
    const double h = std::min({far, kAtClamps * far + rate * to_edge[i], kAtLoads * far + rate * to_load[i]});
    return std::max(h, kFinestWanted);
  };
  // The spacing far away with which the number of points is that of even spacing: it falls as the spacing grows.
  double low = 1.0, high = kCoarsestWanted;
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double far = 0.5 * (low + high);
    double needed = 0.0;
    for (Index i = 0; i < n; ++i) needed += shares[i] / (wantedAt(i, far) * wantedAt(i, far));
    (needed > area ? low : high) = far;
  }
  std::vector<double> wanted(n);
  for (Index i = 0; i < n; ++i) wanted[i] = wantedAt(i, high);
  return wanted;
}

}  // namespace deformable_surface::simulation
