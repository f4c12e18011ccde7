#include "rest.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <utility>

#include "../../behind_noise.h"
#include "../../clamp_edges.h"
#include "../../half_frame.h"
#include "../../parts.h"
#include "../../points_between.h"
#include "../../rest_parts.h"
#include "../../rest_steps.h"
#include "../../spacing.h"
#include "../../unconstrained_parts.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kCountTolerance = 100, kMaxRefills = 3;  // of the wanted number: one in kCountTolerance may be missing
constexpr Index kOneByOneOfHalf = 6000;                  // points of half a frame: a third of its time with three times as many
constexpr int kMaxPrunings = 5;  // passes that drop points which belong to no surface; each can uncover a few more
constexpr Index kFewOfRim = 6;   // points at the rim of no hole, by chance
// Of what the points of a cloud cover by their distances: they may have lost area below the first share, and have where more than
// the second one of them has next to no triangles. Shipped scenes, some 90 scans and meshes, and random clouds have triangles at
// 96 % of their points or more; clouds in rows, 1.5 to 8 times as far apart as the points along them, that lose area: at 48 % or
// less.
constexpr double kSuspicious = 0.75, kBare = 0.15;
constexpr double kNoArea = 0.05;       // of what a point covers
constexpr Index kAround = 8;           // neighbours that tell it
constexpr double kBandOfOneRow = 0.5;  // spacings of the points up to which a pinned band is of one row

// Fewer points can form more parts than the cloud has. Only the largest of these parts, and held ones, are wanted.
std::vector<char> markWanted(const SceneParams& params, const RestSurface& s) {
  std::vector<char> wanted(s.points.size(), 1);
  const bool drops = params.input.unconstrained_parts == UnconstrainedParts::kDrop;
  if (params.input.largest_parts == 0 && !drops) return wanted;
  const Parts parts = findParts(static_cast<Index>(s.points.size()), linksOf(s.rings.ring));
  if (params.input.largest_parts > 0) wanted = markLargest(parts, params.input.largest_parts);
  if (!drops) return wanted;
  const std::vector<char> held = markHeldParts(params, parts, s.points);
  for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = wanted[i] && held[i];
  return wanted;
}

// Makes the simulation points, their cells and their rings. Points that belong to no surface (far outliers, hairs) are dropped
// and move with the others. Returns how many.
Index connect(const SceneParams& params, const RestSurface& full, std::vector<Index> kept, RestSurface& s) {
  const cloud::CleanCloud& dense = full.dense;
  const Index before = static_cast<Index>(kept.size());
  for (int pruning = 0;; ++pruning) {
    takePoints(dense, kept, s);
    // Normals of the coarse set: neighbouring stars agree more often with them than with normals of fine details.
    const Index k = params.neighbors.k;
    const bool is_euclidean = params.neighbors.areEuclidean();
    if (!is_euclidean) s.cells = cloud::findGeodesicCells(dense.positions, full.dense_neighbors, kept, k);
    for (std::size_t i = 0; i < full.leader.size() && !is_euclidean; ++i)
      if (full.leader[i] >= 0) s.cells.owner[i] = s.cells.owner[full.leader[i]];
    const Lists neighbors = is_euclidean ? cloud::nearestNeighbors(s.points, k) : s.cells.neighbors;
    if (kept.size() < dense.positions.size()) {
      const Points fine = std::move(s.normals);
      s.normals = cloud::estimateNormals(s.points, neighbors);
      for (std::size_t i = 0; i < kept.size(); ++i)
        if (s.normals[i].dot(fine[i]) < 0.0) s.normals[i] = -s.normals[i];
    }
    s.rings = cloud::buildRings(s.points, s.normals, neighbors);
    const std::vector<char> is_wanted = markWanted(params, s);
    std::vector<Index> rest;
    for (std::size_t i = 0; i < kept.size(); ++i)
      if (is_wanted[i] && s.rings.area[i] > 0.0 && s.rings.ring.count(static_cast<Index>(i)) >= 2) rest.push_back(kept[i]);
    if (rest.size() == kept.size() || pruning == kMaxPrunings) break;
    kept = std::move(rest);
    if (kept.size() < 3) break;
  }
  if (kept.size() < 3 || s.rings.triangles.empty())
    throw InputError(
        "cloud: its " + formatCount(static_cast<Index>(dense.positions.size()), "distinct points span no surface (") +
        formatCount(static_cast<Index>(kept.size()), "have a ring of neighbours); accepted: at least 3 that are not in line"));
  return before - static_cast<Index>(kept.size());
}

// Pins whose band clamps the surface of these points but has only one row of the simulation points, which turn about it: sets
// has_hinged_pins and warns. Copies of fewer points cannot show this error.
void findHingedPins(const SceneParams& params, const Points& dense, const model::MassSpring& surface, RestSurface& s) {
  if (s.points.size() >= dense.size()) return;
  if (surface.hasCurvature() && surface.numHinged() == 0) return;
  const double spacing = findSpacing(s.area, s.points.size());
  const double full_spacing = findSpacing(s.area, dense.size());
  for (std::size_t p = 0; p < params.pins.size(); ++p) {
    const double full = measureBand(dense, params.pins[p]), band = measureBand(s.points, params.pins[p]);
    if (!isBandOfRows(dense, params.pins[p], full_spacing) || band > kBandOfOneRow * spacing) continue;
    s.has_hinged_pins = true;
    s.warnings.push_back("pins[" + std::to_string(p) + "] holds a band " + formatShort(full) +
                         " m wide, which clamps the cloud but is narrower than the spacing of the simulation points, " +
                         formatShort(spacing) +
                         " m, and a hinge to them, by which no error can be estimated: a wider pin or "
                         "more simulation points clamp these, too");
  }
}

// Model and pins on the simulation points. full: the surface with the dense points that they were chosen from.
void buildModel(const SceneParams& params, const RestSurface& full, RestSurface& s) {
  applyPins(params, s);
  s.dense_spacing = full.dense_spacing;
  if (!full.dense.positions.empty()) s.dense_spacing = findSpacing(s.area, full.dense.positions.size());
  if (full.dense.positions.empty()) {
    s.pinned = full.pinned;
    s.clamp_edges = full.clamp_edges;
  } else if (!params.pins.empty() && canClamp(params)) {
    clampPins(params, full, s);
  }
  std::vector<char> patches;
  for (const char mark : s.pinned) patches.push_back(mark != kNotPinned);
  auto made = std::make_unique<model::MassSpring>(s.points, s.normals, s.rings, s.area, s.closed, params.material,
                                                  params.mass_spring, patches, s.clamp_edges);
  const model::MassSpring& surface = *made;
  if (surface.numMassRaised() > 0)
    s.notes.push_back(
        formatCount(surface.numMassRaised(), "points had next to no area; their mass was raised to a thousandth of the median"));
  if (surface.numWithoutBending() > 0)
    s.notes.push_back(
        formatCount(surface.numWithoutBending(), "points have too few neighbours for a curvature and no bending energy"));
  s.model = std::move(made);
  s.values = findRegionValues(params.regions, s.points);
  if (!params.regions.empty()) s.model->pointMaterials()->setMaterial(findShares(params.material, params.material, s.values));
  if (!full.dense.positions.empty()) findHingedPins(params, full.dense.positions, surface, s);
}

// Rims of holes and slits that have no simulation point at a boundary near them: fewer points bridge the gap, and so do the
// copies of the error estimate.
void noteBridgedGaps(const SceneParams& params, RestSurface& s) {
  const Index n = static_cast<Index>(s.dense.positions.size());
  std::vector<char> is_boundary = std::move(s.is_boundary);
  if (static_cast<Index>(s.points.size()) >= n || s.dense_neighbors.size() != n) return;
  if (is_boundary.empty())
    is_boundary = cloud::findBoundary(s.dense.positions, s.dense.normals, s.dense_neighbors, params.neighbors.k).is_boundary;
  const cloud::KdTree tree(s.points);
  std::vector<cloud::Neighbor> nearest;
  Index bridged = 0;
  for (Index i = 0; i < n; ++i) {
    if (!is_boundary[i]) continue;
    tree.nearest(s.dense.positions[i], 3, nearest);
    bridged += std::none_of(nearest.begin(), nearest.end(), [&](const auto& p) { return s.rings.open[p.index] != 0; });
  }
  if (bridged < kFewOfRim) return;
  s.notes.push_back(formatCount(bridged, "points of the cloud lie at the rims of holes or slits that the simulation points, ") +
                    formatShort(findSpacing(s.area, s.points.size())) +
                    " m apart, bridge: the surface is too stiff there, which the error estimate does not show; more simulation "
                    "points resolve them");
}

double sumMasses(const RestSurface& s) { return std::accumulate(s.model->masses().begin(), s.model->masses().end(), 0.0); }

// Links take equal distances in all directions. Where rows are far apart, few triangles lie between them.
void warnOfLostArea(RestSurface& s) {
  const Points& x = s.dense.positions;
  const Index n = static_cast<Index>(x.size());
  if (s.dense_neighbors.size() != n) return;
  std::vector<double> covered(n, 0.0);
  for (Index i = 0; i < n; ++i) {
    const Index num = std::min(kAround, s.dense_neighbors.count(i));
    if (num > 0) covered[i] = kPi * (x[s.dense_neighbors.begin(i)[num - 1]] - x[i]).squaredNorm() / num;
  }
  if (!(s.area < kSuspicious * std::accumulate(covered.begin(), covered.end(), 0.0))) return;
  const std::vector<double> area = cloud::buildRings(x, s.dense.normals, s.dense_neighbors).area;
  Index bare = 0;
  for (Index i = 0; i < n; ++i) bare += area[i] < kNoArea * covered[i];
  if (!(bare > kBare * n)) return;
  s.warnings.push_back(std::to_string(bare) + " of " +
                       formatCount(n, "points have next to no triangles around them, and what they ") +
                       "cover is lost: the surface has only " + formatShort(s.area) + " m^2 and " + formatShort(sumMasses(s)) +
                       " kg, and may fall apart; a cloud sampled evenly avoids this");
}

// Coarser copies may lose a region; their error then shows it.
void requireRegions(const SceneParams& params, const RestSurface& s) {
  for (std::size_t r = 0; r < params.regions.size(); ++r)
    if (std::none_of(s.points.begin(), s.points.end(), [&](const Vec3& p) { return params.regions[r].region.contains(p); }))
      throw InputError("regions[" + std::to_string(r) + "]: the shape holds none of the " +
                       formatCount(static_cast<Index>(s.points.size()),
                                   "simulation points at rest; accepted: a shape that holds at least one"));
}

// Simulation points of a full surface and their surroundings.
void takeSimulationPoints(const SceneParams& params, std::vector<Index> kept, RestSurface& s) {
  // As many as wanted, up to a hundredth, also if some belong to no surface.
  const bool is_by_threshold = params.simplification.target_points == 0 && !params.simplification.threshold.is_auto;
  const Index asked = static_cast<Index>(kept.size());
  Index dropped = connect(params, s, std::move(kept), s);
  for (Index more = 0, refills = 0; !is_by_threshold && refills < kMaxRefills; ++refills) {
    const Index missing = asked - static_cast<Index>(s.points.size());
    if (std::int64_t{missing} * kCountTolerance <= asked || asked + more >= s.order.num_points) break;
    more += missing;
    dropped = connect(params, s, s.order.keepCount(asked + more), s);
  }
  if (std::int64_t{asked - static_cast<Index>(s.points.size())} * kCountTolerance > asked)
    s.notes.push_back(formatCount(asked, "simulation points were chosen, of which ") +
                      formatCount(static_cast<Index>(s.points.size()),
                                  "are left: the others belong to no surface, or to no part "
                                  "that is kept"));
  if (dropped > 0)
    s.notes.push_back("simulation points that no triangle connects with others: " + std::to_string(dropped) +
                      " (they follow the nearest ones and have no contact)");
}

// Along the surface: the usable ones among the coarser points near each point of the level.
Lists findFollowed(const cloud::GeodesicCells& cells, const std::vector<char>& usable, const RestSurface& level, Index k) {
  std::vector<Index> owner;
  for (Index i : level.dense_index) owner.push_back(cells.owner[i]);
  const Lists near = cloud::findChosenNear(cells, owner, level.points, k);
  Lists followed;
  for (Index i = 0; i < near.size(); ++i) {
    std::copy_if(near.begin(i), near.end(i), std::back_inserter(followed.items), [&](Index j) { return usable[j] != 0; });
    followed.offsets.push_back(static_cast<Index>(followed.items.size()));
  }
  return followed;
}

}  // namespace

RestSurface prepareMassSpring(const SceneParams& params, const cloud::PointCloud& input, Index coarsest, bool to_choose) {
  RestSurface s = cleanInput(input);
  const std::optional<Vec3> viewpoint = moveOntoSurface(params.input, input, s);
  leaveOutParts(params, findNeighbors, s);
  std::optional<HalfFrame> half;
  if (!to_choose && viewpoint) half = halveFrame(params, s);
  RestSurface& seen = half ? half->surface : s;
  FoundNeighbors found = half ? FoundNeighbors{} : findNeighbors(params, s);
  cloud::Boundary boundary = completeNormals(viewpoint, params.neighbors.k, std::move(found.normals), seen);
  std::vector<Index> kept = chooseSimulationPoints(params, chooseHeldPoints(params, seen.dense.positions), boundary, coarsest,
                                                   seen, half ? kOneByOneOfHalf : cloud::kOneByOne);
  s.area = cloud::measureArea(seen.dense.positions, seen.dense.normals, seen.dense_neighbors, found.are_nearest);
  if (half)
    takeHalf(*viewpoint, std::move(*half), kept, s);
  else
    s.is_boundary = std::move(boundary.is_boundary);
  noteLeftOut(s);
  if (to_choose) return s;
  takeSimulationPoints(params, std::move(kept), s);
  followSimulationPoints(params, s);
  return s;
}

RestSurface finishMassSpringRest(const SceneParams& params, RestSurface s, const ModelKind::Choose& choose) {
  if (choose) {
    takeSimulationPoints(params, s.order.keepCount(choose(s)), s);
    followSimulationPoints(params, s);
  }
  buildModel(params, s, s);
  requireRegions(params, s);
  noteBridgedGaps(params, s);
  warnOfLostArea(s);
  s.notes.push_back("area " + formatShort(s.area) + " m^2, mass " + formatShort(sumMasses(s)) + " kg");
  noteFollowing(s);
  return s;
}

RestSurface makeMassSpringTrial(const SceneParams& params, const RestSurface& full, Index points) {
  RestSurface s;
  s.dense = full.dense;
  s.dense_neighbors = full.dense_neighbors;
  s.leader = full.leader;
  s.order = full.order;
  s.closed = full.closed;
  s.area = full.area;
  takeSimulationPoints(params, full.order.keepCount(points), s);
  buildModel(params, s, s);
  return s;
}

RestSurface makeCoarserMassSpring(const SceneParams& params, const RestSurface& of, Index target) {
  RestSurface s;
  s.area = of.area;
  s.closed = of.closed;
  connect(params, of, of.order.keepCount(target), s);
  buildModel(params, of, s);
  s.between = choosePointsBetween(params, of.dense, s, false);
  s.load_points = chooseLoadPoints(params, of.dense, s, kMostLoadPointsOfCopies, s.between);
  return s;
}

CoarserLevel makeMassSpringCopies(const SceneParams& params, const RestSurface& level) {
  CoarserLevel copies;
  const Index n = static_cast<Index>(level.points.size()), num_full = static_cast<Index>(level.dense.positions.size());
  copies.is_simplified = n < num_full;
  copies.unresolved = 1.0 - static_cast<double>(n) / num_full;
  copies.surface = makeCoarserMassSpring(params, level, std::max(kCoarsestPoints, n / kCoarserRatio));
  const RestSurface& surface = copies.surface;
  // Both are ascending lists of the full surface's points. No point follows one that the level had to drop.
  std::vector<char> usable;
  for (Index i : surface.dense_index) {
    const auto found = std::lower_bound(level.dense_index.begin(), level.dense_index.end(), i);
    const bool exists = found != level.dense_index.end() && *found == i;
    copies.common.push_back(exists ? static_cast<Index>(found - level.dense_index.begin()) : Index{-1});
    usable.push_back(exists ? 1 : 0);
  }
  const bool is_euclidean = params.neighbors.areEuclidean();
  Lists followed;
  if (!is_euclidean) followed = findFollowed(surface.cells, usable, level, params.transfer.k);
  copies.refine = [transfer = transfer::Transfer(level.points, level.normals, surface.points, usable, params.transfer,
                                                 is_euclidean ? nullptr : &followed)](const Points& coarse, Points& fine) {
    transfer.apply(coarse, fine);
  };
  return copies;
}

RestSurface copyCoarserMassSpring(const SceneParams& params, const RestSurface& of) {
  RestSurface s;
  s.area = of.area;
  s.closed = of.closed;
  s.points = of.points;
  s.normals = of.normals;
  s.dense_index = of.dense_index;
  s.rings = of.rings;
  s.between = of.between;
  s.load_points = of.load_points;
  buildModel(params, of, s);
  return s;
}

}  // namespace deformable_surface::simulation
