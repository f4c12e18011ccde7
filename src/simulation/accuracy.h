// The choice of the number of simulation points from the accuracy or the time per step that a scene asks for.
#pragma once

#include "deformable_surface/simulation/accuracy_choice.h"
#include "deformable_surface/simulation/prepared_surface.h"

namespace deformable_surface::simulation {

/// The rest surface with the number of simulation points chosen from params.accuracy; without a target, the number that params
/// state. Throws InputError.
RestSurface buildChosen(const SceneParams& params, const cloud::PointCloud& input, AccuracyChoice& choice);
/// The same of a surface that was prepared to_choose if the scene has an accuracy target.
RestSurface buildChosen(const SceneParams& params, RestSurface prepared, AccuracyChoice& choice);
/// Without trials, of a scene with a position_error: the number of points of a scene without it, of which nothing is known.
RestSurface buildUntried(const SceneParams& params, const cloud::PointCloud& input, AccuracyChoice& choice);

}  // namespace deformable_surface::simulation
