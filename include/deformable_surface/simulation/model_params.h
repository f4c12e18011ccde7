// The options of every model: the part of the registry (src/simulation/models/registry.cpp) that is in scenes.
#pragma once

#include "deformable_surface/model/elastic_solid/elastic_solid_params.h"
#include "deformable_surface/model/mass_spring/mass_spring_params.h"
#include "deformable_surface/model/oriented_particles/oriented_particles_params.h"

namespace deformable_surface::simulation {

constexpr const char* kDefaultModel = "mass_spring";

struct ModelOptions {
  model::MassSpringParams mass_spring;
  model::OrientedParticlesParams oriented_particles;
  model::ElasticSolidParams elastic_solid;
};

}  // namespace deformable_surface::simulation
