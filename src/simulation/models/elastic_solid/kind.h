// What elastic solids bring to a simulation. For the registry alone.
#pragma once

#include "deformable_surface/simulation/model_kind.h"

namespace deformable_surface::simulation {

const ModelKind& elasticSolidKind();

}  // namespace deformable_surface::simulation
