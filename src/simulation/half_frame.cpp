#include "half_frame.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <utility>

#include "rest_parts.h"
#include "rest_steps.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kLargeFrame = 100000;  // points: smaller ones are ready in a second anyway
constexpr Index kPixelsPerPoint = 12;  // pixels of the lattice per simulation point: enough for their rings
constexpr Index kPinned = 3;           // pixels of the lattice in every pin: as many as choosePinPoints() takes
constexpr Index kListed = 12;          // neighbours of a pixel off the lattice
constexpr Index kBlock = 4096;

bool isWanted(const SceneParams& params, const RestSurface& s) {
  const Index n = static_cast<Index>(s.dense.positions.size());
  const Index points = countWanted(params, n);
  return n >= kLargeFrame && !s.pixel_links.isEmpty() && params.neighbors.geodesic_exponent.is_auto && s.dense.normals.empty() &&
         params.input.min_gap == 0.0 && !params.output.resample && points > 0 &&
         params.simplification.density == cloud::PointDensity::kUniform && params.accuracy.position_error == 0.0 &&
         params.accuracy.step_budget == 0.0 && points <= n / 4 / kPixelsPerPoint;
}

bool arePinsSeen(const SceneParams& params, const Points& points) {
  return std::all_of(params.pins.begin(), params.pins.end(), [&](const PinParams& pin) {
    return std::count_if(points.begin(), points.end(), [&](const Vec3& p) { return pin.region.contains(p); }) >= kPinned;
  });
}

// The lists of the lattice; for a pixel off the lattice, the nearest one on it and the first of the list of that one.
Lists spreadNeighbors(const HalfFrame& half) {
  const std::vector<Index>& points = half.lattice.points;
  const Lists &followed = half.lattice.followed, &lists = half.surface.dense_neighbors;
  const Index n = followed.size();
  Lists all;
  all.offsets.resize(n + 1);
  const auto isOfLattice = [&](Index i) { return followed.count(i) > 0 && points[*followed.begin(i)] == i; };
  for (Index i = 0; i < n; ++i) {
    Index count = 0;
    if (isOfLattice(i))
      count = lists.count(*followed.begin(i));
    else if (followed.count(i) > 0)
      count = std::min(kListed, lists.count(*followed.begin(i))) + 1;
    all.offsets[i + 1] = all.offsets[i] + count;
  }
  all.items.resize(all.offsets[n]);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (followed.count(i) == 0) continue;
      const Index leader = *followed.begin(i);
      Index* to = all.items.data() + all.offsets[i];
      if (!isOfLattice(i)) *to++ = points[leader];
      for (const Index* j = lists.begin(leader); to != all.items.data() + all.offsets[i + 1]; ++j) *to++ = points[*j];
    }
  });
  return all;
}

}  // namespace

std::optional<HalfFrame> halveFrame(const SceneParams& params, const RestSurface& s) {
  if (!isWanted(params, s)) return std::nullopt;
  HalfFrame half;
  half.lattice = cloud::takeEverySecond(s.pixel_links, s.pixel_links.findPoints(s.dense.point_of_input), s.dense.positions);
  Points& positions = half.surface.dense.positions;
  for (const Index i : half.lattice.points) positions.push_back(s.dense.positions[i]);
  if (!arePinsSeen(params, positions)) return std::nullopt;
  half.surface.dense_neighbors = cloud::findNeighbors(half.lattice.links, half.lattice.place, positions, 2 * params.neighbors.k);
  half.surface.pixel_links = half.lattice.links;
  return half;
}

void takeHalf(const Vec3& eye, HalfFrame half, std::vector<Index>& kept, RestSurface& s) {
  const std::vector<Index>& points = half.lattice.points;
  const Lists& followed = half.lattice.followed;
  const Index n = followed.size();
  s.dense.normals.resize(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      Vec3 sum = Vec3::Zero();
      for (const Index* k = followed.begin(i); k != followed.end(i); ++k) sum += half.surface.dense.normals[*k];
      if (sum.isZero(0.0)) sum = eye - s.dense.positions[i];
      if (sum.isZero(0.0)) sum = Vec3::UnitZ();  // some cameras put pixels without a depth at the origin of the camera
      s.dense.normals[i] = sum.normalized();
    }
  });
  s.dense_neighbors = spreadNeighbors(half);
  s.closed = half.surface.closed;

  // The pixels off the lattice are removed first.
  s.leader.resize(n);
  s.order.num_points = n;
  Index alone = 0;
  for (Index i = 0; i < n; ++i) {
    s.leader[i] = followed.count(i) > 0 ? points[*followed.begin(i)] : -1;
    alone += s.leader[i] < 0;
    if (s.leader[i] != i) s.order.removed.push_back(i);
  }
  s.order.diameter.assign(s.order.removed.size(), 0.0);
  for (const Index k : half.surface.order.removed) s.order.removed.push_back(points[k]);
  s.order.diameter.insert(s.order.diameter.end(), half.surface.order.diameter.begin(), half.surface.order.diameter.end());
  std::vector<char> is_left_out(points.size());
  for (const Index k : half.surface.order.left_out) is_left_out[k] = 1;
  for (Index i = 0; i < n; ++i)
    if (followed.count(i) > 0 && is_left_out[*followed.begin(i)]) s.order.left_out.push_back(i);
  s.order.num_left_out = half.surface.order.num_left_out;
  for (Index& k : kept) k = points[k];

  s.notes.push_back("every second pixel of every second row shows enough of the surface for so few simulation points: " +
                    formatCount(static_cast<Index>(points.size()), "points") +
                    (alone > 0 ? "; " + formatCount(alone, "others are not linked to any of them and follow the nearest") : ""));
  s.notes.insert(s.notes.end(), half.surface.notes.begin(), half.surface.notes.end());
  s.warnings.insert(s.warnings.end(), half.surface.warnings.begin(), half.surface.warnings.end());
}

}  // namespace deformable_surface::simulation
