// What the mass-spring surface brings to a simulation. For the registry alone.
#pragma once

#include "deformable_surface/simulation/model_kind.h"

namespace deformable_surface::simulation {

const ModelKind& massSpringKind();

}  // namespace deformable_surface::simulation
