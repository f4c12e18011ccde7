// The choice of the number of simulation points, of the membrane stiffness and of the integrator from the accuracy that a scene
// asks for.
#pragma once

#include "deformable_surface/simulation/accuracy_choice.h"
#include "deformable_surface/simulation/rest_surface.h"

namespace deformable_surface::simulation {

/// Points times sub-steps of the first trial, before anything is known: some ten seconds of one core.
constexpr double kMostFirst = 1e8;

/// The fewest points whose error is expected below params.accuracy.position_error, as far as trials pay. It depends on the scene
/// only: trials count work, not time.
void chooseByError(const SceneParams& params, const RestSurface& full, AccuracyChoice& choice, double most_first = kMostFirst);

}  // namespace deformable_surface::simulation
