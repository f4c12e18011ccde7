// The loops in which velocities, spins, positions and orientations change, over plain arrays.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::solve {

/// Turns points begin .. end - 1 for a time dt, s, by the exact exponential: q <- exp(dt w / 2) q, with spins w (rad/s). Those
/// with held (n; null: none) stay as they are. The bits of a point depend on nothing but the point. orientations: unit, and so
/// afterwards.
void turnPoints(Index begin, Index end, double dt, const Points& spins, const char* held, Orientations& orientations);

/// Half kicks of coordinates, and the drift after them. decay, kick: (size) of half a sub-step; kick is the time over the mass.
struct HalfKicks {
  const double *decay, *kick;
};
/// v <- decay v + kick force.
void kickFirst(Index size, HalfKicks half, const double* force, double* velocity);
/// v <- decay (v + kick force): the end of a sub-step.
void kickLast(Index size, HalfKicks half, const double* force, double* velocity);
/// The end of one sub-step and the beginning of the next.
void kickTwice(Index size, HalfKicks half, const double* force, double* velocity);
/// position += dt v. predicted: v at the end of the sub-step with the force at its beginning.
void drift(Index size, double dt, HalfKicks half, const double* force, const double* velocity, double* position,
           double* predicted);

}  // namespace deformable_surface::solve
