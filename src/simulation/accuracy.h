// The choice of the number of simulation points from the accuracy or the time per step that a scene asks for.
#pragma once

#include "deformable_surface/simulation/accuracy_choice.h"
#include "deformable_surface/simulation/prepared_surface.h"

#include <functional>

#include "error_estimator.h"

namespace deformable_surface::simulation {

/// The first number of points tried: its coarser copies still carry a shape, and a step of it costs next to nothing.
constexpr Index kFewestTried = 8 * kCoarsestPoints;

/// The rest surface with the number of simulation points chosen from params.accuracy; without a target, the number that params
/// state. Throws InputError.
RestSurface buildChosen(const SceneParams& params, const cloud::PointCloud& input, AccuracyChoice& choice);
/// The same of a surface that was prepared to_choose if the scene has an accuracy target.
RestSurface buildChosen(const SceneParams& params, RestSurface prepared, AccuracyChoice& choice);

/// Time of a step, s: the least of the last few calls of step(), each of which returns its time. The first never counts.
/// A probe that fits the budget (s) is run longer than one that does not. Infinite if a step is.
double timeSteps(const std::function<double()>& step, double budget);

/// The largest number, up to n, of points whose step fits the budget (s); time_step(points) returns the time of a step (s). The
/// number is doubled until it does not fit; then one number in between is tried.
Index chooseByTime(Index n, double budget, const std::function<double(Index)>& time_step, AccuracyChoice& choice);

}  // namespace deformable_surface::simulation
