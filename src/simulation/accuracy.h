// The choice of the number of simulation points from the accuracy or the time per step that a scene asks for.
#pragma once

#include "deformable_surface/simulation/accuracy_choice.h"
#include "deformable_surface/simulation/rest_surface.h"

namespace deformable_surface::simulation {

/// The rest surface with the number of simulation points that params.accuracy leads to; without a wish, the one that params
/// state. Throws InputError.
RestSurface buildChosen(const SceneParams& params, const cloud::PointCloud& input, AccuracyChoice& choice);

}  // namespace deformable_surface::simulation
