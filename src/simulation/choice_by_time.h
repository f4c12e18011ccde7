// The choice of the number of simulation points from the time per step that a scene asks for.
#pragma once

#include "deformable_surface/simulation/accuracy_choice.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <functional>

namespace deformable_surface::simulation {

/// The most points whose step fits params.accuracy.step_budget, with auto's integrator or with the other one if that leads to a
/// smaller estimate.
void chooseByBudget(const SceneParams& params, const RestSurface& full, AccuracyChoice& choice);

/// Time of a step, s: the least of the last few calls of step(), each of which returns its time. The first never counts.
/// A probe that fits the budget (s) is run longer than one that does not. Infinite if a step is.
double timeSteps(const std::function<double()>& step, double budget);

/// The largest number, up to n, of points whose step fits the budget (s); time_step(points) returns the time of a step (s). The
/// number is doubled until it does not fit; then one number in between is tried.
Index chooseByTime(Index n, double budget, const std::function<double(Index)>& time_step, AccuracyChoice& choice);

}  // namespace deformable_surface::simulation
