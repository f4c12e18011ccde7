#include "settle_particles.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kept_neighbors.h"
#include "deformable_surface/solve/integrator.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {
namespace {

constexpr Index kBlock = 256;
constexpr Index kMaxSweeps = 400;  // uneven scans are even after about half as many
constexpr double kStill = 1e-3;    // spacings in one sweep: below it sliding has ended
// Spacings that a first sweep would move: far above rounding of a lattice, far below any scan.
constexpr double kAtRest = 1e-6;
constexpr double kLongestSlide = 0.1;  // spacings in one sweep, so that no particle passes another
constexpr double kRelaxed = 0.25;      // of the way to where springs of the lattice would end; 1 is the limit of stability
constexpr Index kAround = 3;           // dense points that say where the surface is: the least that span it
constexpr Index kLookedAt = 8;         // nearest ones among which those that face the same way are taken
constexpr double kFlat = 1e-6;         // rad from neighbour to neighbour: above the rounding of a plane's curvature
constexpr Index kMaxIterations = 40;   // hundreds of steps of the last relaxation: the remaining motion of scans is slow
constexpr double kNear = 1.0;          // spacings (rms) from the end of sliding: scans take about half, crumpling several
constexpr double kTolerance = 1e-4;    // of its first force

// The surface of the dense points near a particle that faces a way: the mean of the nearest planes, weighted by the inverse of
// their distances, so that each dense point lies on it.
struct Place {
  Vec3 point, normal;
};
Place findSurface(const cloud::CleanCloud& dense, const std::vector<cloud::Neighbor>& near, const Vec3& at, const Vec3& facing) {
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
  double weights = 0.0;
  Index used = 0;
  for (const cloud::Neighbor& q : near) {
    if (!(dense.normals[q.index].dot(facing) > 0.0)) continue;
    if (!(q.squared_distance > 0.0) && used == 0) return {dense.positions[q.index], dense.normals[q.index]};
    const double weight = 1.0 / std::sqrt(q.squared_distance);
    point += weight * dense.positions[q.index];
    normal += weight * dense.normals[q.index];
    weights += weight;
    if (++used == kAround) break;
  }
  if (used == 0) return {at, facing};
  point /= weights;
  normal.normalize();
  return {at - normal * normal.dot(at - point), normal};
}

// lengthening: of the relaxation's longest step, which is 0.4 of the stable one.
void relax(model::OrientedParticles& model, const HeldPoints& held, const solve::IntegratorParams& params, double lengthening,
           model::State& state) {
  model.adopt(state);
  state.velocities.assign(state.positions.size(), Vec3::Zero());
  state.spins.assign(state.positions.size(), Vec3::Zero());
  const std::vector<const solve::ExternalLoad*> no_loads;
  const solve::System system(model, no_loads, held.places, 0.0, &held.turns);
  solve::makeIntegrator(solve::IntegratorType::kStatic, params, true)
      ->advance(system, 0.0, 1.0, lengthening * model.findStableStep(state), state);
}

}  // namespace

Settled measureMoves(const Points& from, const Points& to) {
  Settled moves;
  double squares = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double squared = (to[i] - from[i]).squaredNorm();
    squares += squared;
    moves.largest = std::max(moves.largest, std::sqrt(squared));
  }
  moves.root_mean_square = std::sqrt(squares / static_cast<double>(from.size()));
  return moves;
}

bool slideParticles(const cloud::CleanCloud& dense, const model::OrientedParticles& attraction, const HeldPoints& held,
                    model::State& state) {
  const model::Lattice& lattice = attraction.lattice();
  // A particle between neighbours all around: each ordered pair counts, and directions in the plane by half.
  const double stiffness = 6.0 * model::findLennardJonesCurvature(lattice.pair, lattice.pair.distance);
  if (!(stiffness > 0.0)) return false;
  const double mobility = kRelaxed / stiffness, longest = kLongestSlide * lattice.spacing;
  const cloud::KdTree tree(dense.positions);
  const Index n = state.size();
  cloud::KeptNearest nearest(tree, dense.positions, kLookedAt, n);
  Points forces;
  std::vector<double> moved(n);
  bool is_moved = false;
  for (Index sweep = 0; sweep < kMaxSweeps; ++sweep) {
    forces.assign(n, Vec3::Zero());
    attraction.addForces(state, forces);
    parallelFor(n, kBlock, [&](Index begin, Index end) {
      std::vector<cloud::Neighbor> near;
      for (Index i = begin; i < end; ++i) {
        Vec3 move = mobility * forces[i];
        const Vec3 normal = state.orientations[i] * Vec3::UnitZ();
        move -= normal * normal.dot(move);
        const double length = move.norm();
        moved[i] = held.places[i] ? 0.0 : length;
        if (sweep == 0) continue;  // only looks
        if (!held.places[i]) state.positions[i] += length > longest ? Vec3(longest / length * move) : move;
        if (held.places[i] && held.turns[i]) continue;
        nearest.find(i, state.positions[i], near);
        const Place place = findSurface(dense, near, state.positions[i], normal);
        if (!held.places[i]) state.positions[i] = place.point;
        if (!held.turns[i])
          state.orientations[i] = (Quaternion::FromTwoVectors(normal, place.normal) * state.orientations[i]).normalized();
      }
    });
    const double farthest = *std::max_element(moved.begin(), moved.end());
    if (sweep == 0 && !(farthest > kAtRest * lattice.spacing)) return false;
    is_moved = is_moved || sweep > 0;
    if (sweep > 0 && !(farthest > kStill * lattice.spacing)) break;
  }
  return is_moved;
}

void relaxParticles(model::OrientedParticles& model, const HeldPoints& held, Index max_iterations, double tolerance,
                    model::State& state) {
  solve::IntegratorParams params;
  params.max_iterations = max_iterations;
  params.tolerance = tolerance;
  relax(model, held, params, 1.0, state);
}

void relaxFar(model::OrientedParticles& model, const HeldPoints& held, Index max_iterations, model::State& state) {
  constexpr double kLengthening = 2.0;  // steps of up to 0.8 of the stable one: on five shapes of 600 samples, beside 0.4
  solve::IntegratorParams params;
  params.tolerance = kTolerance;
  params.max_iterations = max_iterations;
  relax(model, held, params, kLengthening, state);
}

void restoreShape(model::OrientedParticles& model, const HeldPoints& held, model::State& state) {
  // Chosen on a sphere, a torus and a pretzel of 600 samples: with more rounds the pretzel tore after time 0.
  constexpr Index kRounds = 8, kFewIterations = 2;
  const std::vector<model::ParticleTraits> given = state.traits;
  for (Index round = 0; round < kRounds; ++round) {
    relaxFar(model, held, kFewIterations, state);
    model::State found = state;
    model.keepShape(found);
    for (Index i = 0; i < state.size(); ++i)
      state.traits[i].rest_curvature += given[i].rest_curvature - found.traits[i].rest_curvature;
  }
}

void relaxInShape(model::OrientedParticles& model, const HeldPoints& held, model::State& state) {
  // With 8 three of ten seeds of the scene particles_fit were not at rest.
  constexpr Index kLastIterations = 20;
  restoreShape(model, held, state);
  relaxFar(model, held, kLastIterations, state);
}

double findUnrest(const model::OrientedParticles& model, const std::vector<char>& held, const model::State& state) {
  // Of the stiffness of a bond times the spacing. 22 grown surfaces: at most 7e-5 on 13 that then were below 5 mm/s, and at least
  // 1.2e-3 on nine on which some particles came to 0.1 m/s and more.
  constexpr double kUnrest = 3e-4;
  const std::vector<const solve::ExternalLoad*> no_loads;
  Points forces;
  solve::System(model, no_loads, held, 0.0).computeForces(0.0, state, forces);
  double largest = 0.0;
  for (const Vec3& force : forces) largest = std::max(largest, force.norm());
  const model::Lattice& lattice = model.lattice();
  const double bond = model::findLennardJonesCurvature(lattice.pair, lattice.pair.distance) * lattice.spacing;
  return largest > kUnrest * bond ? largest / model.masses().front() : 0.0;
}

Settled settleParticles(const cloud::CleanCloud& dense, const model::OrientedParticles& attraction, const HeldPoints& held,
                        model::OrientedParticles& model, model::State& state) {
  const Points before = state.positions;
  const bool has_slid = slideParticles(dense, attraction, held, state);
  model.keepLayers(state);
  model.keepShape(state);
  const double flat = kFlat / model.lattice().spacing;
  const bool is_bent = std::any_of(state.traits.begin(), state.traits.end(), [flat](const model::ParticleTraits& traits) {
    return !(traits.rest_curvature.cwiseAbs().maxCoeff() <= flat);
  });
  Settled settled;
  if (!has_slid && !is_bent) {
    for (model::ParticleTraits& traits : state.traits) traits.rest_curvature.setZero();
    model.adopt(state);
    return settled;
  }
  const model::State even = state;
  relaxParticles(model, held, kMaxIterations, kTolerance, state);
  const bool is_near = measureMoves(even.positions, state.positions).root_mean_square < kNear * model.lattice().spacing;
  if (!is_near) state = even;
  settled = measureMoves(before, state.positions);
  settled.is_near = is_near;
  return settled;
}

}  // namespace deformable_surface::simulation
