// The sentences about a step for users, made from the numbers that the solvers report.
#pragma once

#include "deformable_surface/solve/time_march.h"

#include <string>

namespace deformable_surface::simulation {

/// Why a step failed, as the end of "step 3 ..."; empty for no failure.
std::string describeFailure(const solve::StepFailure& failure);

/// The notice about a step: another integrator, repeated steps, forces that were not balanced; empty if there is nothing
/// to say. params: those that the step was taken with. num_stopped: points that self-contact stopped short.
std::string describeStep(const solve::TimeMarch::Outcome& outcome, const solve::IntegratorParams& params, Index num_stopped = 0);

}  // namespace deformable_surface::simulation
