// The ModelKind of oriented particles. Only the registry includes it.
#pragma once

#include "deformable_surface/simulation/model_kind.h"

namespace deformable_surface::simulation {

const ModelKind& orientedParticlesKind();

}  // namespace deformable_surface::simulation
