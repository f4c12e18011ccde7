// The sentences about a step for users, made from the numbers that the solvers report.
#pragma once

#include "deformable_surface/solve/time_march.h"

#include <string>

namespace deformable_surface::simulation {

/// Why a step failed, as the end of "step 3 ..."; empty for no failure.
std::string describeFailure(const solve::StepFailure& failure);

/// The notice of a step that `auto` took by another integrator than the one before; else empty. params: of the step.
std::string describeChange(const solve::TimeMarch::Outcome& outcome, const solve::IntegratorParams& params);
/// Of a step that was taken again: why, and how. substeps: of the last time.
std::string describeRetry(const solve::StepFailure& why, bool is_implicit, Index substeps);
/// What contact did in a step: nothing, or something touches, or contact of the surface with itself stopped points short.
enum class Touch { kNone, kTouches, kStopped };
/// Of a search that ended before the forces were balanced.
std::string describeUnbalance(const solve::SolveReport& report, const solve::IntegratorParams& params, bool is_static,
                              Touch touch);
/// Of steps that the chosen integrator did not take, at least in part: so many of the last ones.
std::string describeFallbacks(solve::IntegratorType chosen, Index fallbacks, Index steps);
/// Of implicit steps with so many iterations on average, where Verlet would be faster. is_touched: a tool touches.
std::string describeCostlySteps(bool is_touched, double iterations, Index verlet_substeps, const solve::IntegratorParams& params);
/// Of steps in which contact of the surface with itself looks at very many pairs of its parts for each point in a sub-step.
/// attracting: the names of tools that pull on points.
std::string describeCostlyContact(const std::vector<std::string>& attracting);
/// Why a step of this integrator was refused, with advice where something else may help. has_implicit: whether `auto` may take
/// the implicit method.
std::string describeRefusal(const solve::StepFailure& failure, solve::IntegratorType chosen, bool has_implicit);
/// Why a static step was refused after which parts that only tools held were so far away, m.
std::string describeCarriedAway(double way);
/// Of knives that cut off so many single points in a step.
std::string describeDicing(Index points);
/// Of a step in which contact took the motion of parts, in so many sub-steps.
std::string describeHalt(const solve::SolveReport& report);

}  // namespace deformable_surface::simulation
