// The sentences that a user reads of a step: made here, of the numbers that the solvers report.
#pragma once

#include "deformable_surface/solve/time_march.h"

#include <string>

namespace deformable_surface::simulation {

/// What was wrong with a step, as the end of "step 3 ..."; empty for no failure.
std::string describeFailure(const solve::StepFailure& failure);

/// What a user should know of a step: another integrator, steps that were taken again, forces that were not balanced; empty if
/// there is nothing to say. params: those that the step was taken with.
std::string describeStep(const solve::TimeMarch::Outcome& outcome, const solve::IntegratorParams& params);

}  // namespace deformable_surface::simulation
