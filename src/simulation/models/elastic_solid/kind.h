// The ModelKind of elastic solids. Only the registry includes it.
#pragma once

#include "deformable_surface/simulation/model_kind.h"

namespace deformable_surface::simulation {

const ModelKind& elasticSolidKind();

}  // namespace deformable_surface::simulation
