// The largest strain that can be set for bonds of particles to break at. Scenes are checked by it before there is a lattice.
#pragma once

#include "deformable_surface/model/oriented_particles/oriented_particles_params.h"

#include <string>

namespace deformable_surface::model {

/// With free bonds, where bonds of these exponents and this cutoff carry most; with kept bonds, which break by their length
/// alone, the strain at the cutoff. Rounded down to four digits after the point.
double findMostTearStrain(const OrientedParticlesParams& params);
/// Why the tear_strain is refused; empty if it is accepted.
std::string findTearStrainProblem(const OrientedParticlesParams& params);

}  // namespace deformable_surface::model
