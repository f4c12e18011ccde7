// What `expect` may ask of oriented particles. Private to this model.
#pragma once

#include "deformable_surface/model/oriented_particles/oriented_particles.h"
#include "deformable_surface/simulation/simulation.h"

#include <optional>
#include <string>

namespace deformable_surface::simulation {

/// What oriented particles make: kind of surface, distances to the nearest other particle, who came and went, how many touch a
/// tool. Nothing: it is no quantity of theirs.
std::optional<double> findParticleQuantity(const std::string& name, const model::OrientedParticles& particles,
                                           const Simulation& simulation);

}  // namespace deformable_surface::simulation
