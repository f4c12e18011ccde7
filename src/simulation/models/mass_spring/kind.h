// The ModelKind of the mass-spring surface. Only the registry includes it.
#pragma once

#include "deformable_surface/simulation/model_kind.h"

namespace deformable_surface::simulation {

const ModelKind& massSpringKind();

}  // namespace deformable_surface::simulation
