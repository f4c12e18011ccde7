// Oriented particles on a cloud as it is handed in are not at rest. Here they are brought to rest before time 0. Private.
#pragma once

#include "deformable_surface/cloud/clean.h"
#include "deformable_surface/model/oriented_particles/oriented_particles.h"

namespace deformable_surface::simulation {

/// Which points are held, (n) each, 1 = held: in their places, and in their orientations.
struct HeldPoints {
  std::vector<char> places, turns;
};

/// Particles, alone in the world, towards their equilibrium by FIRE in at most so many hundreds of steps. model: that of the
/// state, which it adopts. The state ends with speeds of zero.
void relaxParticles(model::OrientedParticles& model, const HeldPoints& held, Index max_iterations, double tolerance,
                    model::State& state);

/// The same to a usual tolerance, with steps of twice the length.
void relaxFar(model::OrientedParticles& model, const HeldPoints& held, Index max_iterations, model::State& state);

/// Particles towards the curvature that they remember at first. Under the stress of an uneven lattice they would come to rest
/// beside it, in bumps. Every few hundreds of steps, each rest curvature therefore grows by what the particle's present curvature
/// lacks. Particles without enough neighbours to tell keep theirs. They are not at rest at the end.
void restoreShape(model::OrientedParticles& model, const HeldPoints& held, model::State& state);

/// The same; then all come to rest.
void relaxInShape(model::OrientedParticles& model, const HeldPoints& held, model::State& state);

/// The largest acceleration, m/s^2, of a particle that is not held (n), without loads, where it is so large that particles slip
/// past others; 0 if they are at rest. model: that of the state, which it has adopted.
double findUnrest(const model::OrientedParticles& model, const std::vector<char>& held, const model::State& state);

/// Particles slide by attraction and repulsion alone over the surface of the dense points, which have normals, without leaving
/// it, until they are even. attraction: a model of the same particles without forces of orientation. Returns whether any moved:
/// what is at rest stays to the bit.
bool slideParticles(const cloud::CleanCloud& dense, const model::OrientedParticles& attraction, const HeldPoints& held,
                    model::State& state);

/// How far particles moved until they were at rest, m.
struct Settled {
  double root_mean_square = 0.0, largest = 0.0;
  bool is_near = true;  // false: there is no equilibrium near, and they have only become even
};

/// Between two places of as many particles, (n x 3), m. NaN counts as far.
Settled measureMoves(const Points& from, const Points& to);

/// Makes the cloud a rest shape. Without leaving the surface of the dense points, particles slide by attraction and repulsion
/// alone until they are even; each then keeps the curvature that it has; and all of them relax to equilibrium by all forces, if
/// that is near: where bending is too soft to keep a surface it is a crumpled one. attraction: a model of the same particles
/// without forces of orientation. state: as model.beginAtRest() makes it, with creases; where it is at rest it stays to the bit.
/// dense: with normals. O(n log m) for each of at most some hundred sweeps and some thousand steps.
Settled settleParticles(const cloud::CleanCloud& dense, const model::OrientedParticles& attraction, const HeldPoints& held,
                        model::OrientedParticles& model, model::State& state);

}  // namespace deformable_surface::simulation
