// Access to the model of a simulation of oriented particles, for tests.
#pragma once

#include "deformable_surface/model/oriented_particles/oriented_particles.h"
#include "deformable_surface/simulation/simulation.h"

namespace deformable_surface::test {

inline const model::Lattice& latticeOf(const simulation::Simulation& s) {
  return static_cast<const model::OrientedParticles&>(s.model()).lattice();
}

}  // namespace deformable_surface::test
