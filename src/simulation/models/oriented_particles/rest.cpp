#include "rest.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/median.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/links.h"
#include "deformable_surface/cloud/rings.h"
#include "deformable_surface/model/oriented_particles/oriented_particles.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "../../behind_noise.h"
#include "../../copied_points.h"
#include "../../rest_parts.h"
#include "../../rest_steps.h"
#include "settle_particles.h"

namespace deformable_surface::simulation {
namespace {

// For a curve in the plane y = 0: across the line through the two nearest neighbours, on the side of +z, where none are given. No
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

// Of samples without normals that are hardly denser than the features of their surface. The normals of few neighbours tell the
// sides of thin bodies apart; then more neighbours of the same side give better ones.
cloud::Boundary completeSampleNormals(const std::optional<Vec3>& viewpoint, RestSurface& s) {
  constexpr Index kFew = 6, kMore = 12;
  constexpr int kFits = 2;  // the second sees the sides of neighbours by the normals of the first
  const Points& x = s.dense.positions;
  const Lists more = cloud::nearestNeighbors(x, kMore);
  Lists all = std::exchange(s.dense_neighbors, more);
  Points normals = cloud::estimateNormals(x, cloud::nearestNeighbors(x, kFew));
  cloud::Boundary boundary = completeNormals(viewpoint, kFew, std::move(normals), s, cloud::SideLinks::kMirrored);
  s.dense_neighbors = std::move(all);
  for (int k = 0; k < kFits; ++k) s.dense.normals = cloud::fitNormals(x, more, s.dense.normals);
  return boundary;
}

// Whether the normals of neighbouring points are less than 60 degrees apart. Else the neighbourhoods that gave them were wider
// than the features of the surface, or reached to its other side.
bool areSmooth(const Points& positions, const Points& normals) {
  constexpr double kMostTurned = 0.5;
  const Lists nearest = cloud::nearestNeighbors(positions, 6);
  for (Index i = 0; i < nearest.size(); ++i)
    for (const Index* j = nearest.begin(i); j != nearest.end(i); ++j)
      if (!(normals[i].dot(normals[*j]) > kMostTurned)) return false;
  return true;
}

// Median distance of points to their nearest neighbour.
double findMedianDistance(const Points& points) {
  const Lists nearest = cloud::nearestNeighbors(points, 1);
  std::vector<double> distances;
  for (Index i = 0; i < nearest.size(); ++i)
    if (nearest.count(i) > 0) distances.push_back((points[*nearest.begin(i)] - points[i]).norm());
  return distances.empty() ? 0.0 : findMedian(std::move(distances));
}

// Edge of the equilateral triangle with the mean area of the triangles between the simulation points: the spacing of a hexagonal
// lattice, with or without edges. 0 if there are none.
double findLatticeSpacing(Index k, const RestSurface& s) {
  const cloud::Rings rings = cloud::buildRings(s.points, s.normals, cloud::nearestNeighbors(s.points, k));
  double area = 0.0, count = 0.0;
  for (const double a : rings.area) area += a;
  for (const cloud::Triangle& triangle : rings.triangles) count += triangle.weight;
  return count > 0.0 ? std::sqrt(4.0 * area / (std::sqrt(3.0) * count)) : 0.0;
}

// For a rest shape that is not the cloud's.
void warnOfSpacing(double spacing, RestSurface& s) {
  constexpr double kFar = 1.3;  // of the spacing, either way: bonds of that length are broken or crushed
  const double median = findMedianDistance(s.points);
  if (median < kFar * spacing && spacing < kFar * median) return;
  s.warnings.push_back("the cloud's nearest neighbours are " + formatShort(median) +
                       " m apart (median): such particles fly or fall apart (integrator.type static lets them settle)");
}

// Warns of what makes particles move or separate from the beginning.
void noteUnrest(const SceneParams& params, double spacing, RestSurface& s) {
  // Of E h a^2: with a tenth of it a draping sheet fell apart (docs/oriented_particles.md)
  constexpr double kSoftest = 0.02;
  s.notes.push_back("oriented particles " + formatShort(spacing) + " m apart");
  if (params.oriented_particles.growing == model::Growing::kEdges)
    s.notes.push_back(
        "oriented_particles.growing edges: open edges grow until there are oriented_particles.growth.max_particles, " +
        std::to_string(params.oriented_particles.growth.max_particles) + "; edge_rows is for grow_surface");
  const model::MaterialParams& m = params.material;
  constexpr double kTheirs = 1.0 / 3.0,
                   kNoted = 0.05;  // Poisson's ratio of a lattice; nearer the difference is below that of its defects
  if (params.oriented_particles.bonds == model::ParticleBonds::kFree && !(std::abs(m.poisson_ratio - kTheirs) <= kNoted))
    s.notes.push_back("material.poisson_ratio " + formatShort(m.poisson_ratio) +
                      " counts in bending_rigidity: auto only: a surface of "
                      "particles has 1/3");
  const double stiffness = m.young_modulus * m.thickness * spacing * spacing;
  if (params.oriented_particles.bonds == model::ParticleBonds::kFree && m.bendingRigidity() < kSoftest * stiffness)
    s.warnings.push_back("material.bending_rigidity " + formatShort(m.bendingRigidity()) +
                         " N m is below a fiftieth of E h a^2, " + formatShort(kSoftest * stiffness) +
                         " N m with this spacing a: the particles may crumple instead of staying a surface; a larger "
                         "bending_rigidity, a smaller young_modulus, a smaller spacing or oriented_particles.bonds: kept keeps "
                         "them flat");
}

// The simulation points at rest are where these particles are.
void takePlaces(const model::State& state, model::OrientedParticles& model, RestSurface& s) {
  s.points = state.positions;
  for (Index i = 0; i < state.size(); ++i) s.normals[i] = state.orientations[i] * Vec3::UnitZ();
  model.setRest(state);
}

// Which pins hold while particles settle: those with no other pinned particle within reach of a bond. Pinned neighbours that
// stayed at uneven distances would strain the surface beside them, and a thin one buckles under this stress at the smallest load.
HeldPoints releasePinnedNeighbors(double reach, const RestSurface& s) {
  HeldPoints held{s.pinned, s.pinned_turns};
  const cloud::KdTree tree(s.points);
  std::vector<cloud::Neighbor> near;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    if (!s.pinned[i]) continue;
    tree.withinRadius(s.points[i], reach, near);
    const auto isOther = [&](const cloud::Neighbor& other) {
      return other.index != static_cast<Index>(i) && s.pinned[other.index];
    };
    if (std::any_of(near.begin(), near.end(), isOther)) held.places[i] = held.turns[i] = 0;
  }
  return held;
}

// Neighbours on the surface keep their bonds, with the shape that they have now.
void keepBonds(const model::State& state, Index k, model::OrientedParticles& model, RestSurface& s) {
  cloud::Rings rings = cloud::buildRings(s.points, s.normals, cloud::nearestNeighbors(s.points, k));
  std::vector<model::WeightedTriangle> triangles;
  for (const cloud::Triangle& t : rings.triangles) {
    triangles.push_back({{t.corner[0], t.corner[1], t.corner[2]}, t.weight});
  }
  const Index alone = static_cast<Index>(std::count(rings.area.begin(), rings.area.end(), 0.0));
  if (alone > 0)
    throw InputError("oriented_particles.bonds: found kept with " + formatCount(alone, "particles that belong to no triangle") +
                     "; accepted: clouds of a surface without single points, or free");
  s.area = 0.0;
  for (const double area : rings.area) s.area += area;
  model.keepBonds(state, triangles, std::move(rings.area));
}

// Brings the particles to rest where the cloud is, and takes that as the rest shape. What is at rest stays as it is, bit for bit.
void takeCloudAsRest(Index k, model::OrientedParticles& model, RestSurface& s) {
  const double spacing = model.lattice().spacing;
  model::OrientedParticles attraction = model;
  attraction.leaveOnlyAttraction();
  model::State state;
  state.positions = s.points;
  model.beginAtRest(state);
  for (Index i = 0; i < state.size(); ++i) state.traits[i].is_smooth = !s.creased[i];
  const HeldPoints held = releasePinnedNeighbors(model.lattice().pair.cutoff, s);
  if (model.params().bonds == model::ParticleBonds::kKept) {
    const Points before = s.points;
    slideParticles(s.dense, attraction, held, state);
    takePlaces(state, model, s);
    keepBonds(state, k, model, s);
    const Settled moves = measureMoves(before, s.points);
    if (moves.largest > 0.0)
      s.notes.push_back("particles moved by " + formatShort(moves.root_mean_square / spacing) + " spacings (rms; at most " +
                        formatShort(moves.largest / spacing) +
                        ") before time 0 until they were even; the cloud's points follow them");
    return;
  }
  const Settled settled = settleParticles(s.dense, attraction, held, model, state);
  if (!(settled.largest > 0.0)) return;
  takePlaces(state, model, s);
  s.notes.push_back("particles moved by " + formatShort(settled.root_mean_square / spacing) + " spacings (rms; at most " +
                    formatShort(settled.largest / spacing) + ") before time 0 until they were " +
                    (settled.is_near ? "at rest as the cloud's shape"
                                     : "even; they are not at rest, for the only rest that was found is a "
                                       "crumpled one: material.bending_rigidity is too small, or particles lie on others") +
                    "; the cloud's points follow them (oriented_particles.rest_shape flat: they begin where the points are, "
                    "unless two are too near)");
}

// A flat lattice is the rest shape. Where two particles are so near that their repulsion holds more energy than a bond, the cloud
// would fly apart at once. Particles then slide over the surface until they are even. Other clouds stay as they are, bit for bit.
void partCrushed(model::OrientedParticles& model, RestSurface& s) {
  const double least = model::findLeastDistance(model.lattice().pair);
  const Lists nearest = cloud::nearestNeighbors(s.points, 1);
  const auto isCrushed = [&](Index i) {
    return nearest.count(i) > 0 && (s.points[*nearest.begin(i)] - s.points[i]).norm() < least;
  };
  Index crushed = 0;
  for (Index i = 0; i < nearest.size(); ++i) crushed += isCrushed(i);
  if (crushed == 0) return;
  model::OrientedParticles attraction = model;
  attraction.leaveOnlyAttraction();
  model::State state;
  state.positions = s.points;
  model.beginAtRest(state);
  const HeldPoints held = releasePinnedNeighbors(model.lattice().pair.cutoff, s);
  if (!slideParticles(s.dense, attraction, held, state)) return;
  model.keepLayers(state);
  const Settled moves = measureMoves(s.points, state.positions);
  takePlaces(state, model, s);
  const double spacing = model.lattice().spacing;
  s.notes.push_back(formatCount(crushed, "particles were nearer to another than bonds can hold: all slid over the surface by ") +
                    formatShort(moves.root_mean_square / spacing) + " spacings (rms; at most " +
                    formatShort(moves.largest / spacing) + ") before time 0 to become even; the cloud's points follow them");
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
                       formatCount(m, "points span no surface; accepted: a number"));
  }
  // Particles near in space but apart along the surface at rest do not interact.
  Lists apart;
  if (!params.neighbors.areEuclidean()) apart = cloud::findRefusedPairs(s.points, s.cells.neighbors);
  if (!apart.items.empty())
    s.notes.push_back(formatCount(static_cast<Index>(apart.items.size() / 2),
                                  "pairs of particles are apart over the surface: no bonds form between them"));
  auto particles =
      std::make_unique<model::OrientedParticles>(s.points, s.normals, spacing, params.material, params.oriented_particles, apart);
  s.creased.assign(m, 0);
  for (std::size_t c = 0; c < params.creases.size(); ++c) {
    bool holds_any = false;
    for (Index i = 0; i < m; ++i)
      if (params.creases[c].region.contains(s.points[i])) s.creased[i] = holds_any = true;
    if (!holds_any)
      throw InputError("creases[" + std::to_string(c) + "]: the shape holds none of the " +
                       formatCount(m, "particles at rest; accepted: a shape that holds at least one"));
  }
  if (params.oriented_particles.mode == model::ParticleMode::kPlane) s.across = Vec3::UnitY();
  s.area = m * particles->lattice().area_per_particle;
  noteUnrest(params, particles->lattice().spacing, s);
  model::OrientedParticles& model = *particles;
  s.model = std::move(particles);
  applyPins(params, s);
  if (!apart.items.empty()) {
    model::State given;
    given.positions = s.points;
    model.beginAtRest(given);
    model.keepLayers(given);
  }
  if (params.oriented_particles.grow_surface) return;
  if (params.oriented_particles.restsAsCloud()) return takeCloudAsRest(params.neighbors.k, model, s);
  if (params.oriented_particles.mode == model::ParticleMode::kSpace) partCrushed(model, s);
  warnOfSpacing(model.lattice().spacing, s);
}

// Makes these dense points simulation points.
void takeSimulationPoints(const SceneParams& params, std::vector<Index> kept, RestSurface& s) {
  std::sort(kept.begin(), kept.end());
  takePoints(s.dense, kept, s);
  if (!params.neighbors.areEuclidean())
    s.cells = cloud::findGeodesicCells(s.dense.positions, s.dense_neighbors, kept, 2 * params.neighbors.k);
}

}  // namespace

RestSurface prepareParticles(const SceneParams& params, const cloud::PointCloud& input, Index coarsest, bool to_choose) {
  RestSurface s = cleanInput(input);
  const bool is_curve = params.oriented_particles.mode == model::ParticleMode::kPlane;
  if (is_curve) warnOfUnits(s);
  const std::optional<Vec3> viewpoint = is_curve ? input.viewpoint : moveOntoSurface(params.input, input, s);
  leaveOutParts(params, findNeighbors, s);
  FoundNeighbors found = findNeighbors(params, s);
  const bool are_samples = params.oriented_particles.grow_surface && s.dense.normals.empty() && !is_curve;
  const std::size_t num_notes = s.notes.size();
  cloud::Boundary boundary =
      is_curve ? completeCurveNormals(s) : completeNormals(viewpoint, params.neighbors.k, std::move(found.normals), s);
  if (are_samples && !areSmooth(s.dense.positions, s.dense.normals)) {
    s.dense.normals.clear();
    s.notes.resize(num_notes);  // the side of the normals is told anew
    boundary = completeSampleNormals(viewpoint, s);
  }
  std::vector<Index> kept = chooseSimulationPoints(params, choosePinPoints(params, s.dense.positions), boundary, coarsest, s);
  noteLeftOut(s);
  if (to_choose)
    s.area = cloud::measureArea(s.dense.positions, s.dense.normals, s.dense_neighbors, found.are_nearest);
  else
    takeSimulationPoints(params, std::move(kept), s);
  return s;
}

RestSurface finishParticlesRest(const SceneParams& params, RestSurface s, const ModelKind::Choose& choose) {
  if (choose) takeSimulationPoints(params, s.order.keepCount(choose(s)), s);
  buildParticles(params, s);
  followSimulationPoints(params, s);
  noteFollowing(s, params.oriented_particles.grow_surface);
  return s;
}

RestSurface makeParticlesTrial(const SceneParams& params, const RestSurface& full, Index points) {
  RestSurface s;
  s.dense = full.dense;
  s.dense_neighbors = full.dense_neighbors;
  s.closed = full.closed;
  takeSimulationPoints(params, full.order.keepCount(points), s);
  buildParticles(params, s);
  return s;
}

// Its particles slide to places of their own: none is at the place of one of the level. Nor are those of the level at places of a
// simulation of all points. However few points are left out, all of the surface counts as unresolved.
CoarserLevel makeParticleCopies(const SceneParams& params, const RestSurface& level) {
  const Index n = static_cast<Index>(level.points.size()), num_full = static_cast<Index>(level.dense.positions.size());
  CoarserLevel copies;
  copies.is_simplified = n < num_full;
  copies.surface = makeParticlesTrial(params, level, std::max(kCoarsestPoints, n / kCoarserRatio));
  RestSurface& surface = copies.surface;
  const bool is_euclidean = params.neighbors.areEuclidean();
  Lists followed;
  if (!is_euclidean) {
    std::vector<Index> owner;
    for (const Index i : level.dense_index) owner.push_back(surface.cells.owner[i]);
    followed = cloud::findChosenNear(surface.cells, owner, level.points, params.transfer.k);
  }
  const std::vector<char> usable(surface.points.size(), 1);
  copies.refine = [transfer = transfer::Transfer(level.points, level.normals, surface.points, usable, params.transfer,
                                                 is_euclidean ? nullptr : &followed)](const Points& coarse, Points& fine) {
    transfer.apply(coarse, fine);
  };
  surface.dense = {};
  surface.dense_neighbors = {};
  return copies;
}

// Pins hold the particles that were in them before all slid.
RestSurface copyCoarserParticles(const SceneParams&, const RestSurface& of) {
  RestSurface s = copyPointsAndModel(of);
  s.pinned = of.pinned;
  s.pin_of = of.pin_of;
  s.pinned_turns = of.pinned_turns;
  s.creased = of.creased;
  return s;
}

}  // namespace deformable_surface::simulation
