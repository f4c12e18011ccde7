#include "deformable_surface/simulation/rest_surface.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/median.h"
#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/links.h"
#include "deformable_surface/cloud/normals.h"
#include "deformable_surface/cloud/simplification.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "deformable_surface/model/oriented_particles/oriented_particles.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "accuracy.h"
#include "behind_noise.h"
#include "clamp_edges.h"
#include "parts.h"
#include "rest_parts.h"
#include "settle_particles.h"
#include "unheld.h"
#include "wanted_spacing.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kAutoPoints = 1000;  // simulation points that auto keeps: a few per cent of real time on one core
// Of simulation points, at least, for one loaded point that is kept: a load on more of them acts everywhere, and what is left
// would sample nothing, above all in the error estimate's copies of a quarter of the points.
constexpr Index kPointsPerLoad = 10;
// Of simulation points, at least, for one corner that is kept, if there are more corners than of any clean outline of few points.
constexpr Index kPointsPerCorner = 10, kCornersOfFew = 32;
constexpr Index kCountTolerance = 20, kMaxRefills = 3;  // of the number asked for: one of so many may be missing
constexpr int kMaxPrunings = 5;  // passes that drop points which belong to no surface; each can uncover a few more

bool isZero(const Vec3& v) { return v.isZero(0.0); }

// The 2k neighbours of the dense points: in space, or over the surface. What normals say beside positions is what is given, else
// what the neighbours in space show: returned if it is what the neighbours over the surface show as well, else empty.
Points findNeighbors(const SceneParams& scene, RestSurface& s) {
  const cloud::NeighborsParams& params = scene.neighbors;
  if (!s.pixel_links.isEmpty() && params.geodesicness.is_auto) {
    s.dense_neighbors =
        cloud::findNeighbors(s.pixel_links, s.dense.point_of_input, s.dense.positions, 2 * params.k, scene.input.min_gap);
    return {};
  }
  s.dense_neighbors = cloud::nearestNeighbors(s.dense.positions, 2 * params.k);
  if (params.areEuclidean() || s.is_thick) return {};
  cloud::SurfaceSides sides;
  const bool is_given = !s.dense.normals.empty() && std::none_of(s.dense.normals.begin(), s.dense.normals.end(), isZero);
  sides.oriented = is_given;
  sides.normals = is_given ? s.dense.normals : cloud::estimateNormals(s.dense.positions, s.dense_neighbors);
  const Points& positions = s.dense.positions;
  const cloud::GeodesicGraph graph =
      cloud::buildGeodesicGraph(positions, sides, s.dense_neighbors, params.geodesicness, scene.input.min_gap);
  cloud::GeodesicNeighbors found = cloud::keepGeodesicNeighbors(graph, positions, sides, std::move(s.dense_neighbors));
  s.dense_neighbors = std::move(found.lists);
  noteGaps(found, s);
  return is_given || found.num_refused > 0 ? Points{} : std::move(sides.normals);
}

// The parts of the dense points: what links between neighbours connect, over the surface or in the body.
Parts findDenseParts(const SceneParams& params, const RestSurface& of) {
  const cloud::CleanCloud& dense = of.dense;
  const Index n = static_cast<Index>(dense.positions.size());
  const bool is_body = params.model == ModelKind::kElasticSolid && !params.elastic_solid.fill;
  RestSurface s;
  s.dense = dense;
  s.pixel_links = of.pixel_links;
  s.is_thick = of.is_thick;
  Points normals;
  if (is_body) {
    s.dense_neighbors = cloud::nearestNeighbors(dense.positions, 2 * params.neighbors.k);
    keepNearOverBody(params.neighbors, dense.positions, s.dense_neighbors, s);
    normals.assign(n, Vec3::Zero());  // to which every link is flat
  } else {
    normals = findNeighbors(params, s);
    if (normals.empty()) normals = cloud::estimateNormals(dense.positions, s.dense_neighbors);
  }
  const cloud::LinkRule rule(dense.positions, normals, s.dense_neighbors);
  std::vector<std::pair<Index, Index>> links;
  for (Index i = 0; i < n; ++i)
    for (const Index* j = s.dense_neighbors.begin(i); j != s.dense_neighbors.end(i); ++j)
      if (rule.accepts(i, *j)) links.emplace_back(i, *j);
  return findParts(n, links);
}

// Normals of the dense points: those given, estimated (if that has not been done yet) where none is given, all on one consistent
// side. Returns the boundary.
cloud::Boundary completeNormals(const std::optional<Vec3>& viewpoint, Index k, Points normals, RestSurface& s) {
  const Index n = static_cast<Index>(s.dense.positions.size());
  if (normals.empty()) normals = cloud::estimateNormals(s.dense.positions, s.dense_neighbors);
  cloud::Boundary boundary = cloud::findBoundary(s.dense.positions, normals, s.dense_neighbors, k);
  s.closed = std::count(boundary.is_boundary.begin(), boundary.is_boundary.end(), 1) == 0;
  cloud::OrientationRule rule = cloud::OrientationRule::kViewpoint;
  if (s.pixel_links.isEmpty() || !s.dense.normals.empty() || !viewpoint)
    rule = cloud::orientNormals(s.dense.positions, s.dense_neighbors, boundary.is_boundary, s.dense.normals, viewpoint, normals);
  else
    cloud::faceEye(s.dense.positions, *viewpoint, normals);
  // A given normal is taken as it is where it agrees with the side.
  if (!s.dense.normals.empty())
    for (Index i = 0; i < n; ++i)
      if (s.dense.normals[i].dot(normals[i]) > 0.0) normals[i] = s.dense.normals[i];
  s.dense.normals = std::move(normals);
  static const char* const kRules[] = {"the input's normals", "outward (closed surface)", "towards the viewpoint", "+z"};
  s.notes.push_back(std::string("normals point by ") + kRules[static_cast<int>(rule)]);
  return boundary;
}

// Of a curve in the plane y = 0: across the line through the two nearest neighbours, on the side of +z, where none are given. No
// boundary.
cloud::Boundary completeCurveNormals(RestSurface& s) {
  const Points& x = s.dense.positions;
  for (Index i = 0; s.dense.normals.size() < x.size(); ++i) {
    const Index* near = s.dense_neighbors.begin(i);
    const Vec3 along =
        x[near[0]] - (s.dense_neighbors.count(i) > 1 && (x[near[1]] - x[i]).dot(x[near[0]] - x[i]) < 0.0 ? x[near[1]] : x[i]);
    Vec3 normal(-along.z(), 0.0, along.x());
    if (normal.z() < 0.0) normal = -normal;
    s.dense.normals.push_back(normal.norm() > 0.0 ? Vec3(normal.normalized()) : Vec3::UnitZ());
  }
  return {std::vector<char>(x.size(), 0), std::vector<char>(x.size(), 0), std::vector<float>(x.size(), 0.0f)};
}

// How many simulation points a threshold leaves, before they are chosen: rings of that diameter in a hexagonal lattice.
Index expectPoints(double threshold, double area) {
  const double spacing = 0.5 * threshold;
  const double points = area / (0.5 * std::sqrt(3.0) * spacing * spacing);
  return points < kMaxIndex ? static_cast<Index>(points) : kMaxIndex;
}

// Adds the points at which loads act to those that are kept. fewest: how many simulation points there are at least.
void keepLoadedPoints(const SceneParams& params, Index fewest, std::vector<Index>& kept, RestSurface& s) {
  if (params.model != ModelKind::kMassSpring) return;  // particles keep to their lattice
  const std::vector<Index> loaded = chooseLoadedPoints(params, s.dense.positions);
  const Index num_loaded = static_cast<Index>(loaded.size());
  if (num_loaded <= fewest / kPointsPerLoad) {
    kept.insert(kept.end(), loaded.begin(), loaded.end());
  } else {
    s.notes.push_back(count(num_loaded, "points of the cloud are loaded, more than a tenth of ") +
                      count(fewest, "simulation points: loads act on the nearest of these"));
  }
}

// Of simplification.density: adaptive. Empty where that is even spacing.
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

// Records the order of removal as far as it is needed and returns the simulation points.
std::vector<Index> chooseSimulationPoints(const SceneParams& params, const std::vector<Index>& protected_points,
                                          cloud::Boundary& boundary, Index coarsest, RestSurface& s) {
  const Index n = static_cast<Index>(s.dense.positions.size());
  const cloud::SimplificationParams& how = params.simplification;
  const bool by_threshold =
      how.method == cloud::SimplificationMethod::kDelaunay && how.target_points == 0 && !how.threshold.is_auto;
  Index target = how.target_points > 0 ? how.target_points : kAutoPoints;
  if (how.method == cloud::SimplificationMethod::kNone) target = n;
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
                              boundary.is_corner, !params.neighbors.areEuclidean(), by_threshold ? 0 : target, wanted);
    if (s.order.num_left_out > 0)
      s.notes.push_back(count(s.order.num_left_out, "parts of the cloud, with ") +
                        count(s.order.num_left_out_points,
                              "points, are too small for so few simulation points, and ride along "
                              "with the nearest ones"));
  }
  return by_threshold ? s.order.keepDiameter(how.threshold.value) : s.order.keepCount(target);
}

void take(const cloud::CleanCloud& dense, const std::vector<Index>& kept, RestSurface& s) {
  s.dense_index = kept;
  s.points.clear();
  s.normals.clear();
  for (Index i : kept) {
    s.points.push_back(dense.positions[i]);
    s.normals.push_back(dense.normals[i]);
  }
}

// Fewer points can fall into more parts than the cloud has: of those only the largest, and what is held, are wanted, too.
std::vector<char> markWanted(const SceneParams& params, const RestSurface& s) {
  std::vector<char> wanted(s.points.size(), 1);
  const bool drops = params.input.unheld == Unheld::kDrop;
  if (params.input.keep_parts == 0 && !drops) return wanted;
  const Parts parts = findParts(static_cast<Index>(s.points.size()), linksOf(s.rings.ring));
  if (params.input.keep_parts > 0) wanted = markLargest(parts, params.input.keep_parts);
  if (!drops) return wanted;
  const std::vector<char> held = markHeldParts(params, parts, s.points);
  for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = wanted[i] && held[i];
  return wanted;
}

// Makes the simulation points, their cells and their rings; those that belong to no surface (far outliers, hairs) are dropped and
// ride along. Returns how many.
Index connect(const SceneParams& params, const cloud::CleanCloud& dense, const Lists& dense_neighbors, std::vector<Index> kept,
              RestSurface& s) {
  const Index before = static_cast<Index>(kept.size());
  for (int pruning = 0;; ++pruning) {
    take(dense, kept, s);
    // Normals of the coarse set: with them neighbouring stars agree more often than with those of the fine details.
    const Index k = params.neighbors.k;
    const bool is_euclidean = params.neighbors.areEuclidean();
    if (!is_euclidean) s.cells = cloud::findGeodesicCells(dense.positions, dense_neighbors, kept, k);
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
        "cloud: its " + count(static_cast<Index>(dense.positions.size()), "distinct points span no surface (") +
        count(static_cast<Index>(kept.size()), "have a ring of neighbours); accepted: at least 3 that are not in line"));
  return before - static_cast<Index>(kept.size());
}

// Of points to the nearest other one.
double findMedianDistance(const Points& points) {
  const Lists nearest = cloud::nearestNeighbors(points, 1);
  std::vector<double> distances;
  for (Index i = 0; i < nearest.size(); ++i)
    if (nearest.count(i) > 0) distances.push_back((points[*nearest.begin(i)] - points[i]).norm());
  return distances.empty() ? 0.0 : findMedian(std::move(distances));
}

// Edge of the equilateral triangle whose area is that of the mean triangle between the simulation points: of a hexagonal lattice
// its spacing, edges or none. 0 if they span none.
double findLatticeSpacing(Index k, const RestSurface& s) {
  const cloud::Rings rings = cloud::buildRings(s.points, s.normals, cloud::nearestNeighbors(s.points, k));
  double area = 0.0, count = 0.0;
  for (const double a : rings.area) area += a;
  for (const cloud::Triangle& triangle : rings.triangles) count += triangle.weight;
  return count > 0.0 ? std::sqrt(4.0 * area / (std::sqrt(3.0) * count)) : 0.0;
}

// What will make particles move or come apart from the beginning.
void noteUnrest(const SceneParams& params, double spacing, RestSurface& s) {
  constexpr double kFar = 1.3;  // of the spacing, either way: bonds of that length are broken or crushed
  // Of E h a^2: with a tenth of it a draping sheet has gone to pieces (docs/oriented_particles.md)
  constexpr double kSoftest = 0.02;
  s.notes.push_back("oriented particles " + formatShort(spacing) + " m apart");
  const double median = findMedianDistance(s.points);
  if (!params.oriented_particles.restsAsCloud() && !(median < kFar * spacing && spacing < kFar * median))
    s.warnings.push_back("the cloud's nearest neighbours are " + formatShort(median) +
                         " m apart (median): such particles fly or fall apart (integrator.type static lets them settle)");
  const model::MaterialParams& m = params.material;
  constexpr double kTheirs = 1.0 / 3.0,
                   kNoted = 0.05;  // Poisson's ratio of a lattice; nearer the difference is below that of its defects
  if (!(std::abs(m.poisson_ratio - kTheirs) <= kNoted))
    s.notes.push_back("material.poisson_ratio " + formatShort(m.poisson_ratio) +
                      " counts in bending_rigidity: auto only: a surface of "
                      "particles has 1/3");
  const double stiffness = m.young_modulus * m.thickness * spacing * spacing;
  if (m.bendingRigidity() < kSoftest * stiffness)
    s.warnings.push_back("material.bending_rigidity " + formatShort(m.bendingRigidity()) +
                         " N m is below a fiftieth of E h a^2, " + formatShort(kSoftest * stiffness) +
                         " N m with this spacing a: the particles may crumple instead of staying a surface; a larger "
                         "bending_rigidity, a smaller young_modulus or a smaller spacing keeps them flat");
}

// Model and pins on the simulation points. full: the surface with the dense points that they are of.
void buildModel(const SceneParams& params, const RestSurface& full, RestSurface& s) {
  applyPins(params, s);
  if (full.dense.positions.empty()) {
    s.pinned = full.pinned;
    s.clamp_edges = full.clamp_edges;
  } else if (!params.pins.empty() && canClamp(params)) {
    clampPins(params, full, s);
  }
  auto mass_spring = std::make_unique<model::MassSpring>(s.points, s.normals, s.rings, s.area, s.closed, params.material,
                                                         params.mass_spring, s.pinned, s.clamp_edges);
  if (mass_spring->numMassRaised() > 0)
    s.notes.push_back(
        count(mass_spring->numMassRaised(), "points had next to no area; their mass was raised to a thousandth of the median"));
  if (mass_spring->numWithoutBending() > 0)
    s.notes.push_back(
        count(mass_spring->numWithoutBending(), "points have too few neighbours for a curvature and no bending energy"));
  s.model = std::move(mass_spring);
  s.values = findRegionValues(params.regions, s.points);
  if (!params.regions.empty()) s.model->setMaterial(findShares(params.material, params.material, s.values));
  if (!full.dense.positions.empty()) findHingedPins(params, full.dense.positions, s);
}

// Brings the particles to rest where the cloud is, and takes that for the rest shape. What is at rest stays to the bit.
void takeCloudAsRest(model::OrientedParticles& model, RestSurface& s) {
  const double spacing = model.lattice().spacing;
  model::OrientedParticles attraction = model;
  attraction.leaveOnlyAttraction();
  model::State state;
  state.positions = s.points;
  model.beginAtRest(state);
  for (Index i = 0; i < state.size(); ++i) state.traits[i].is_smooth = !s.creased[i];
  const Settled settled = settleParticles(s.dense, attraction, s.pinned, s.pinned_turns, model, state);
  if (!(settled.largest > 0.0)) return;
  s.points = state.positions;
  for (Index i = 0; i < state.size(); ++i) s.normals[i] = state.orientations[i] * Vec3::UnitZ();
  model.setRest(state);
  s.notes.push_back("particles moved by " + formatShort(settled.root_mean_square / spacing) + " spacings (rms; at most " +
                    formatShort(settled.largest / spacing) + ") before time 0 until they were " +
                    (settled.is_near ? "at rest as the cloud's shape"
                                     : "even; they are not at rest, for the only rest that was found is a "
                                       "crumpled one: material.bending_rigidity is too small, or particles lie on others") +
                    "; the cloud's points ride on them (oriented_particles.rest_shape flat: they begin where the points are)");
}

// Oriented particles on the simulation points, which need not be a surface yet.
void buildParticles(const SceneParams& params, RestSurface& s) {
  const Index m = static_cast<Index>(s.points.size());
  double spacing = 0.0;
  if (params.oriented_particles.spacing.is_auto) {
    if (params.oriented_particles.mode == model::ParticleMode::kPlane) {
      spacing = findMedianDistance(s.points);
    } else {
      spacing = findLatticeSpacing(params.neighbors.k, s);
    }
    if (!(spacing > 0.0))
      throw InputError("oriented_particles.spacing: found auto, but the " +
                       count(m, "points span no surface; accepted: a number"));
  }
  // What is near in space and apart over the surface at rest stays without forces.
  Lists apart;
  if (!params.neighbors.areEuclidean()) apart = cloud::findRefusedPairs(s.points, s.cells.neighbors);
  if (!apart.items.empty())
    s.notes.push_back(count(static_cast<Index>(apart.items.size() / 2),
                            "pairs of particles are apart over the surface: no forces act between them"));
  auto particles =
      std::make_unique<model::OrientedParticles>(s.points, s.normals, spacing, params.material, params.oriented_particles, apart);
  s.creased.assign(m, 0);
  for (std::size_t c = 0; c < params.creases.size(); ++c) {
    bool holds_any = false;
    for (Index i = 0; i < m; ++i)
      if (params.creases[c].region.contains(s.points[i])) s.creased[i] = holds_any = true;
    if (!holds_any)
      throw InputError("creases[" + std::to_string(c) + "]: the shape holds none of the " +
                       count(m, "particles at rest; accepted: a shape that holds at least one"));
  }
  s.area = m * particles->lattice().area_per_particle;
  noteUnrest(params, particles->lattice().spacing, s);
  model::OrientedParticles& model = *particles;
  s.model = std::move(particles);
  applyPins(params, s);
  if (params.oriented_particles.restsAsCloud() && !params.oriented_particles.fit) takeCloudAsRest(model, s);
}

// Coarser copies may lose a region, which their error then shows.
void requireRegions(const SceneParams& params, const RestSurface& s) {
  for (std::size_t r = 0; r < params.regions.size(); ++r)
    if (std::none_of(s.points.begin(), s.points.end(), [&](const Vec3& p) { return params.regions[r].region.contains(p); }))
      throw InputError(
          "regions[" + std::to_string(r) + "]: the shape holds none of the " +
          count(static_cast<Index>(s.points.size()), "simulation points at rest; accepted: a shape that holds at least one"));
}

// Simulation points of a full surface with masses, model and pins. area: finds that of the dense points, m^2.
void finishSurface(const SceneParams& params, std::vector<Index> kept, const std::function<double()>& area, RestSurface& s) {
  // As many as were asked for, but for a twentieth, also where some belong to no surface.
  const bool is_by_threshold = params.simplification.target_points == 0 && !params.simplification.threshold.is_auto;
  const Index asked = static_cast<Index>(kept.size());
  Index dropped = connect(params, s.dense, s.dense_neighbors, std::move(kept), s);
  for (Index more = 0, refills = 0; !is_by_threshold && refills < kMaxRefills; ++refills) {
    const Index missing = asked - static_cast<Index>(s.points.size());
    if (missing * kCountTolerance <= asked || asked + more >= s.order.num_points) break;
    more += missing;
    dropped = connect(params, s.dense, s.dense_neighbors, s.order.keepCount(asked + more), s);
  }
  if ((asked - static_cast<Index>(s.points.size())) * kCountTolerance > asked)
    s.notes.push_back(count(asked, "simulation points were chosen, of which ") +
                      count(static_cast<Index>(s.points.size()),
                            "are left: the others belong to no surface, or to no part "
                            "that is kept"));
  if (dropped > 0)
    s.notes.push_back(count(dropped, "simulation points belong to no surface and ride along with the nearest one"));
  // The area of the full surface; where every point is simulated it is that of the rings.
  const bool is_all = s.points.size() == s.dense.positions.size();
  s.area = is_all ? std::accumulate(s.rings.area.begin(), s.rings.area.end(), 0.0) : area();
  buildModel(params, s, s);
}

}  // namespace

RestSurface buildRestSurface(const SceneParams& params, const cloud::PointCloud& input, Index coarsest,
                             const std::function<Index(const RestSurface&)>& choose) {
  RestSurface s = cleanInput(input);
  const bool is_body = params.model == ModelKind::kElasticSolid && !params.elastic_solid.fill;
  const bool is_curve =
      params.model == ModelKind::kOrientedParticles && params.oriented_particles.mode == model::ParticleMode::kPlane;
  const std::optional<Vec3> viewpoint = is_body || is_curve ? input.viewpoint : moveOntoSurface(params.input, input, s);
  if (is_body) warnOfNoisyBody(params.input, input, s);
  if (params.input.keep_parts > 0) keepLargestParts(params, findDenseParts(params, s), s);
  if (params.input.unheld == Unheld::kDrop) dropUnheld(params, findDenseParts(params, s), s);
  if (params.model == ModelKind::kElasticSolid) {
    if (!is_body) {
      Points estimated = findNeighbors(params, s);
      completeNormals(viewpoint, params.neighbors.k, std::move(estimated), s);
      buildFilledSolid(params, s);
    } else {
      buildRestSolid(params, input, s);
    }
    noteUnheld(params, s);
    return s;
  }
  const Index n = static_cast<Index>(s.dense.positions.size());

  Points estimated = findNeighbors(params, s);
  cloud::Boundary boundary =
      is_curve ? completeCurveNormals(s) : completeNormals(viewpoint, params.neighbors.k, std::move(estimated), s);
  const std::vector<Index> pin_points = choosePinPoints(params, s.dense.positions);
  std::vector<Index> kept = chooseSimulationPoints(params, pin_points, boundary, coarsest, s);
  const auto measureArea = [&] {
    return cloud::measureArea(s.dense.positions, s.dense.normals, s.dense_neighbors, boundary.is_boundary);
  };
  if (choose) {
    s.area = measureArea();
    kept = s.order.keepCount(choose(s));
  }
  const bool is_euclidean = params.neighbors.areEuclidean();
  if (params.model == ModelKind::kOrientedParticles) {
    std::sort(kept.begin(), kept.end());
    take(s.dense, kept, s);
    if (!is_euclidean) s.cells = cloud::findGeodesicCells(s.dense.positions, s.dense_neighbors, kept, 2 * params.neighbors.k);
    buildParticles(params, s);
  } else {
    const double known = s.area;
    finishSurface(
        params, std::move(kept), [&] { return choose ? known : measureArea(); }, s);
    requireRegions(params, s);
  }
  const Lists followed = is_euclidean ? Lists{} : cloud::findChosenNear(s.cells, s.dense.positions, params.transfer.k);
  s.transfer = transfer::Transfer(s.dense.positions, s.dense.normals, s.points, std::vector<char>(s.points.size(), 1),
                                  params.transfer, is_euclidean ? nullptr : &followed);
  if (s.transfer.numDegenerate() > 0)
    s.notes.push_back(
        count(s.transfer.numDegenerate(), "points see simulation points in a line only; across it they move rigidly"));
  s.notes.push_back(count(n, "points, ") + count(static_cast<Index>(s.points.size()), "simulation points, ") +
                    count(static_cast<Index>(s.model->stretchLinks().size() + s.model->bendLinks().size()), "links, ") +
                    count(static_cast<Index>(std::count(s.pinned.begin(), s.pinned.end(), 1)), "pinned"));
  noteUnheld(params, s);
  return s;
}

RestSurface buildTrial(const SceneParams& params, const RestSurface& full, Index points) {
  RestSurface s;
  s.dense = full.dense;
  s.dense_neighbors = full.dense_neighbors;
  s.order = full.order;
  s.closed = full.closed;
  finishSurface(
      params, full.order.keepCount(points), [&] { return full.area; }, s);
  return s;
}

RestSurface buildCoarser(const SceneParams& params, const RestSurface& of, Index target) {
  RestSurface s;
  s.area = of.area;
  s.closed = of.closed;
  connect(params, of.dense, of.dense_neighbors, of.order.keepCount(target), s);
  buildModel(params, of, s);
  return s;
}

RestSurface copyCoarser(const SceneParams& params, const RestSurface& of) {
  RestSurface s;
  s.area = of.area;
  s.closed = of.closed;
  s.points = of.points;
  s.normals = of.normals;
  s.dense_index = of.dense_index;
  s.rings = of.rings;
  if (params.model == ModelKind::kElasticSolid) {
    s.model = of.model->clone();
    applyPins(params, s);
  } else {
    buildModel(params, of, s);
  }
  return s;
}

}  // namespace deformable_surface::simulation
