#include "rest_steps.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/layers.h"
#include "deformable_surface/cloud/links.h"
#include "deformable_surface/cloud/normals.h"
#include "deformable_surface/cloud/row_spacing.h"
#include "deformable_surface/simulation/model_kind.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "accuracy_probe.h"
#include "parts.h"
#include "rest_parts.h"
#include "unconstrained_parts.h"
#include "wanted_spacing.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kAutoPoints = 1000;  // simulation points that auto keeps: a few per cent of real time on one core
// Simulation points, at least, per loaded point that is kept: a load on more of them acts everywhere, and no points would be
// left to sample the surface, above all in the error estimate's copies with a quarter of the points.
constexpr Index kPointsPerLoad = 10;
constexpr double kFarRows = 2.5;     // spacings along them: rows farther apart can come apart
constexpr Index kJoinedShare = 200;  // of the points: one in so many above or below another is more than noise and single creases
constexpr int kTrials = 3;
constexpr Index kFewerJoined = 2;  // of these are left where layers have been told apart: half, at most
// Of the neighbours that are lost then, along the surface over those in other layers. Drawn layers lose up to 2.1 times as many,
// creased sheets 3 to 80 times.
constexpr double kMostAlong = 2.5;
// Of them, per point that had others above or below it. Drawn layers lose up to 21; closed bodies two spacings thick, which would
// fall into their sides, more.
constexpr Index kMostLost = 22;
// Simulation points, at least, per corner that is kept, if there are more corners than any clean outline of few points has.
constexpr Index kPointsPerCorner = 10, kCornersOfFew = 32;

bool isZero(const Vec3& v) { return v.isZero(0.0); }

// The parts of the dense points, connected by links between neighbours, along the surface or in the body.
Parts findDenseParts(const SceneParams& params, const FindNeighbors& find, const RestSurface& of) {
  const cloud::CleanCloud& dense = of.dense;
  const Index n = static_cast<Index>(dense.positions.size());
  RestSurface s;
  s.dense = dense;
  s.pixel_links = of.pixel_links;
  s.is_thick = of.is_thick;
  Points normals = find(params, s).normals;
  if (normals.empty()) normals = cloud::estimateNormals(dense.positions, s.dense_neighbors);
  const cloud::LinkRule rule(dense.positions, normals, s.dense_neighbors);
  std::vector<std::pair<Index, Index>> links;
  for (Index i = 0; i < n; ++i)
    for (const Index* j = s.dense_neighbors.begin(i); j != s.dense_neighbors.end(i); ++j)
      if (rule.accepts(i, *j)) links.emplace_back(i, *j);
  return findParts(n, links);
}

double roundToTwoDigits(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::round(value / unit) * unit;
}

void warnOfRows(RestSurface& s) {
  const cloud::RowSpacing spacing = cloud::findRowSpacing(s.dense.positions, s.dense_neighbors);
  if (spacing.groups < 1.0 / kFarRows)
    s.warnings.push_back(
        "most points have others nearly at the same place, at about " + formatShort(roundToTwoDigits(spacing.groups)) +
        " of the distance to the points around: two layers or more, or one scan several times with a shift; layers so near are "
        "joined to one body; a cloud of one layer, with each point once, avoids this");
  if (spacing.rows < kFarRows) return;
  const std::string times = spacing.rows < cloud::kFarthestRows
                                ? "about " + formatShort(std::round(10.0 * spacing.rows) / 10.0) + " times"
                                : formatShort(cloud::kFarthestRows) + " times or more";
  s.warnings.push_back("the points lie in rows, which are " + times +
                       " as far apart as the points along them: the surface may come apart between rows, and bends across "
                       "them as few points do; a cloud sampled evenly avoids both");
}

// The expected number of simulation points for a threshold: rings of that diameter in a hexagonal lattice.
Index expectPoints(double threshold, double area) {
  const double spacing = 0.5 * threshold;
  const double points = area / (0.5 * std::sqrt(3.0) * spacing * spacing);
  return points < kMaxIndex ? static_cast<Index>(points) : kMaxIndex;
}

// Adds the points at which loads act to the kept ones. fewest: least number of simulation points.
void keepLoadedPoints(const SceneParams& params, Index fewest, std::vector<Index>& kept, RestSurface& s) {
  if (!findModel(params.model).traits().is_tuned) return;  // its points keep to their lattice
  const std::vector<Index> loaded = chooseLoadedPoints(params, s.dense.positions);
  const Index num_loaded = static_cast<Index>(loaded.size());
  if (num_loaded <= fewest / kPointsPerLoad) {
    kept.insert(kept.end(), loaded.begin(), loaded.end());
  } else {
    s.notes.push_back(formatCount(num_loaded, "points of the cloud are loaded, more than a tenth of ") +
                      formatCount(fewest, "simulation points: loads act on the nearest of these"));
  }
}

// For simplification.density: adaptive. Empty if that gives even spacing.
std::vector<double> wantSpacing(const SceneParams& params, const std::vector<char>& is_boundary, Index target, RestSurface& s) {
  std::vector<double> wanted = findWantedSpacing(params, is_boundary, target, s);
  if (wanted.empty()) {
    s.notes.push_back("simplification.density adaptive: no small pin clamps, no force acts on a point: points are spaced evenly");
  } else {
    const auto [least, largest] = std::minmax_element(wanted.begin(), wanted.end());
    s.notes.push_back("simplification.density adaptive: simulation points are to be " + formatShort(*least) + " to " +
                      formatShort(*largest) + " mean spacings apart");
  }
  return wanted;
}

// Neighbours along the surface, and the normals by which they are found and which they give.
struct Sought {
  cloud::SurfaceSides sides;
  std::vector<char> is_own;  // (dense) normals that are not those of all neighbours in space
  cloud::GeodesicNeighbors found;
};

void seekAlongSurface(const SceneParams& scene, const Points& positions, Lists in_space, Sought& sought) {
  const cloud::GeodesicGraph graph =
      cloud::buildGeodesicGraph(positions, sought.sides, in_space, scene.neighbors.geodesic_exponent, scene.input.min_gap);
  sought.found = cloud::keepGeodesicNeighbors(graph, positions, sought.sides, std::move(in_space));
  if (sought.sides.oriented || sought.found.num_refused == 0) return;
  // The others have been estimated from the same lists.
  for (std::size_t i = 0; i < positions.size(); ++i) sought.is_own[i] = sought.is_own[i] || sought.found.is_changed[i];
  cloud::estimateNormals(positions, sought.found.lists, sought.is_own, sought.sides.normals);
}

// Where many points have neighbours above or below them, normals on which the points around agree may tell layers apart.
void tellLayersApart(const SceneParams& scene, Sought& sought, RestSurface& s) {
  const Points& positions = s.dense.positions;
  const auto countJoined = [&](const Sought& by) { return cloud::countLinkedUp(positions, by.sides.normals, by.found.lists); };
  const Index joined = countJoined(sought);
  Index left = joined;
  for (int trial = 0; trial < kTrials && left > static_cast<Index>(positions.size()) / kJoinedShare; ++trial) {
    Lists in_space = cloud::nearestNeighbors(positions, 2 * scene.neighbors.k);
    cloud::AgreedNormals agreed = cloud::agreeOnNormals(positions, in_space, sought.sides.normals);
    Sought again;
    again.sides.normals = std::move(agreed.normals);
    again.sides.at_creases = std::move(agreed.at_creases);
    again.is_own.assign(positions.size(), 1);
    seekAlongSurface(scene, positions, std::move(in_space), again);
    const Index now = countJoined(again);
    const cloud::LostPairs lost = cloud::countLost(positions, again.sides.normals, sought.found.lists, again.found.lists);
    if (kFewerJoined * now > left || lost.along > kMostAlong * lost.up || lost.up + lost.along > kMostLost * left) break;
    sought = std::move(again);
    left = now;
  }
  if (left < joined)
    s.notes.push_back(
        "layers are told apart: " + formatCount(joined, "points had neighbours above or below them, only ") +
        formatCount(left, "have with normals on which the points around each agree, which are used (a filled body falls into ") +
        "layers by this; elastic_solid is the model for it)");
}

}  // namespace

FoundNeighbors findNeighbors(const SceneParams& scene, RestSurface& s) {
  const cloud::NeighborsParams& params = scene.neighbors;
  if (!s.pixel_links.isEmpty() && params.geodesic_exponent.is_auto) {
    s.dense_neighbors = cloud::findNeighbors(s.pixel_links, s.pixel_links.findPoints(s.dense.point_of_input), s.dense.positions,
                                             2 * params.k, scene.input.min_gap);
    return {};
  }
  s.dense_neighbors = cloud::nearestNeighbors(s.dense.positions, *cloud::findTree(s.dense), 2 * params.k);
  // Particles have no rings that could come apart.
  if (!s.is_thick && !findModel(scene.model).traits().is_oriented) warnOfRows(s);
  if (params.areEuclidean() || s.is_thick) return {{}, std::vector<char>(s.dense.positions.size(), 1)};
  const Points& positions = s.dense.positions;
  const bool is_given = !s.dense.normals.empty() && std::none_of(s.dense.normals.begin(), s.dense.normals.end(), isZero);
  Sought sought;
  sought.sides.oriented = is_given;
  if (is_given) {
    sought.sides.normals = s.dense.normals;
  } else {
    cloud::NormalsInSpace normals = cloud::estimateNormalsInSpace(positions, s.dense_neighbors);
    sought.sides.normals = std::move(normals.normals);
    sought.sides.at_creases = std::move(normals.at_creases);
    sought.is_own = std::move(normals.is_own);
  }
  seekAlongSurface(scene, positions, std::move(s.dense_neighbors), sought);
  if (!is_given && params.geodesic_exponent.is_auto) tellLayersApart(scene, sought, s);
  noteGaps(sought.found, s);
  s.dense_neighbors = std::move(sought.found.lists);
  std::vector<char> are_nearest(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) are_nearest[i] = !sought.found.is_changed[i];
  return {is_given ? Points() : std::move(sought.sides.normals), std::move(are_nearest)};
}

FoundNeighbors findBodyNeighbors(const SceneParams& params, RestSurface& s) {
  s.dense_neighbors = cloud::nearestNeighbors(s.dense.positions, *cloud::findTree(s.dense), 2 * params.neighbors.k);
  keepNearOverBody(params.neighbors, s.dense.positions, s.dense_neighbors, s);
  return {Points(s.dense.positions.size(), Vec3::Zero()), {}};
}

void leaveOutParts(const SceneParams& params, const FindNeighbors& find, RestSurface& s) {
  if (params.input.largest_parts > 0) keepLargestParts(params, findDenseParts(params, find, s), s);
  if (params.input.unconstrained_parts == UnconstrainedParts::kDrop)
    dropUnconstrained(params, findDenseParts(params, find, s), s);
}

cloud::Boundary completeNormals(const std::optional<Vec3>& viewpoint, Index k, Points normals, RestSurface& s,
                                cloud::SideLinks links) {
  const Index n = static_cast<Index>(s.dense.positions.size());
  if (normals.empty()) normals = cloud::estimateNormals(s.dense.positions, s.dense_neighbors);
  cloud::Boundary boundary = cloud::findBoundary(s.dense.positions, normals, s.dense_neighbors, k);
  s.closed = std::count(boundary.is_boundary.begin(), boundary.is_boundary.end(), 1) == 0;
  cloud::OrientationRule rule = cloud::OrientationRule::kViewpoint;
  if (s.pixel_links.isEmpty() || !s.dense.normals.empty() || !viewpoint)
    rule = cloud::orientNormals(s.dense.positions, s.dense_neighbors, boundary.is_boundary, s.dense.normals, viewpoint, normals,
                                links);
  else
    cloud::faceEye(s.dense.positions, *viewpoint, normals);
  // A given normal is kept as it is if it agrees with the side.
  Index num_turned = 0;
  if (!s.dense.normals.empty())
    for (Index i = 0; i < n; ++i) {
      const double agreement = s.dense.normals[i].dot(normals[i]);
      if (agreement > 0.0) normals[i] = s.dense.normals[i];
      num_turned += agreement < 0.0;
    }
  s.dense.normals = std::move(normals);
  static const char* const kRules[] = {"as the input's do", "outward (closed surface)", "towards the viewpoint", "to +z"};
  s.notes.push_back(std::string("normals point ") + kRules[static_cast<int>(rule)]);
  if (num_turned > 0)
    s.notes.push_back(formatCount(num_turned, "given normals point to the other side of the surface than most, and were turned"));
  return boundary;
}

Index countWanted(const SceneParams& params, Index n) {
  const cloud::SimplificationParams& how = params.simplification;
  if (how.method == cloud::SimplificationMethod::kNone) return n;
  if (how.target_points > 0) return how.target_points;
  return how.threshold.is_auto ? kAutoPoints : 0;
}

std::vector<Index> chooseSimulationPoints(const SceneParams& params, const std::vector<Index>& protected_points,
                                          cloud::Boundary& boundary, Index coarsest, RestSurface& s, Index one_by_one) {
  const Index n = static_cast<Index>(s.dense.positions.size());
  const cloud::SimplificationParams& how = params.simplification;
  const Index target = countWanted(params, n);
  const bool by_threshold = target == 0;
  s.order.num_points = n;
  const Index last = by_threshold ? Index{3} : std::min(target, coarsest);
  if (last < n) {
    Index expected = target;
    if (by_threshold) expected = expectPoints(how.threshold.value, estimateArea(s, params.neighbors.k, boundary.is_boundary));
    const bool is_tried = params.accuracy.position_error > 0.0 || params.accuracy.step_budget > 0.0;
    const Index fewest = std::min(n, is_tried ? std::min(expected, kFewestTried) : expected);
    std::vector<Index> kept = protected_points;
    keepLoadedPoints(params, fewest, kept, s);
    std::vector<double> wanted;
    if (how.density == cloud::PointDensity::kAdaptive)
      wanted = wantSpacing(params, boundary.is_boundary, std::min(expected, n), s);
    cloud::limitCorners(std::max(kCornersOfFew, std::min(expected, n) / kPointsPerCorner), boundary);
    s.order = cloud::simplify(s.dense.positions, s.dense.normals, params.neighbors.k, last, kept, s.dense_neighbors,
                              boundary.is_corner, !params.neighbors.areEuclidean(), target, wanted, one_by_one);
  }
  return by_threshold ? s.order.keepDiameter(how.threshold.value) : s.order.keepCount(target);
}

void noteLeftOut(RestSurface& s) {
  if (s.order.num_left_out == 0) return;
  s.notes.push_back(formatCount(s.order.num_left_out, "parts of the cloud, with ") +
                    formatCount(static_cast<Index>(s.order.left_out.size()),
                                "points, are too small to get simulation points of their own, and follow the nearest ones; more "
                                "simulation points include "
                                "them"));
}

void takePoints(const cloud::CleanCloud& dense, const std::vector<Index>& kept, RestSurface& s) {
  s.dense_index = kept;
  s.points.clear();
  s.normals.clear();
  for (Index i : kept) {
    s.points.push_back(dense.positions[i]);
    s.normals.push_back(dense.normals[i]);
  }
}

void followSimulationPoints(const SceneParams& params, RestSurface& s) {
  const bool is_euclidean = params.neighbors.areEuclidean();
  const Lists followed = is_euclidean ? Lists{} : cloud::findChosenNear(s.cells, s.dense.positions, params.transfer.k);
  s.transfer = transfer::Transfer(s.dense.positions, s.dense.normals, s.points, std::vector<char>(s.points.size(), 1),
                                  params.transfer, is_euclidean ? nullptr : &followed);
}

void noteFollowing(RestSurface& s, bool will_grow) {
  if (s.transfer.numDegenerate() > 0)
    s.notes.push_back(
        formatCount(s.transfer.numDegenerate(),
                    "points of the cloud follow simulation points that lie in one line; across it they move rigidly"));
  const Index links = static_cast<Index>(stretchLinksOf(*s.model).size() + bendLinksOf(*s.model).size());
  s.notes.push_back(formatCount(static_cast<Index>(s.dense.positions.size()), "points, ") +
                    formatCount(static_cast<Index>(s.points.size()),
                                will_grow ? "simulation points before the surface is grown, " : "simulation points, ") +
                    (will_grow ? "" : formatCount(links, "links, ")) +
                    formatCount(static_cast<Index>(std::count(s.pinned.begin(), s.pinned.end(), 1)), "pinned"));
}

}  // namespace deformable_surface::simulation
