// The work of a step as one number. It is counted and not timed, so that decisions by it are the same on every machine.
#pragma once

#include "deformable_surface/solve/integrator.h"

#include <cmath>

namespace deformable_surface::simulation {

/// Cost of a Newton iteration on so many points, in sub-steps of Verlet.
inline double newtonWork(Index points) {
  // From 128 to 2048 points: between measurements on sheets, whose factors are sparser, and on spheres (docs/decisions/0006).
  constexpr double kFactor = 3.8, kExponent = 0.8;
  return kFactor * std::pow(points, kExponent);
}

/// Work of a step of so many points, in points times sub-steps of Verlet. newton: see newtonWork().
inline double workOf(const solve::SolveReport& taken, Index points, double newton) {
  constexpr double kQuasiNewton = 3.0;  // of an iteration, in passes of forces: 0.06 ms beside 0.02 with 400 points
  const double iteration = taken.is_quasi_newton ? kQuasiNewton : newton;
  const double substeps = taken.iterations > 0 ? iteration * taken.iterations : taken.substeps;
  return static_cast<double>(points) * substeps;
}

}  // namespace deformable_surface::simulation
