#include "accuracy_probe.h"

#include <algorithm>
#include <cmath>

#include "estimated_dynamics.h"
#include "step_work.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kMostKept = 2e6;  // points whose positions are kept of a probe: some fifty megabytes

// A trial ends when it has taken more than this, about ten seconds of one core, and more than all trials before it.
constexpr double kMostWork = 1e8;

}  // namespace

double WorkBudget::left() const {
  const double all = std::max(free_, kShareOfWhole * whole_) - spent_;
  return std::max(0.0, std::min(all, std::max(kMostWork, spent_)));
}

std::string sayPoints(Index points, Index of) { return std::to_string(points) + " of " + std::to_string(of) + " points"; }

bool WorkBudget::allows(double work, double whole) const {
  return spent_ + work <= kShareOfWhole * whole && work <= std::max(kMostWork, spent_);
}

Probe probeError(const SceneParams& params, const RestSurface& full, const AccuracyChoice::Candidate& tried, double target,
                 const Probe* beside, const ProbeLimits& limits) {
  Probe probe;
  probe.candidate = tried;
  SceneParams quiet = params;
  quiet.accuracy = AccuracyParams{};
  quiet.accuracy.regions = params.accuracy.regions;
  quiet.output.resample = quiet.output.error = false;
  quiet.integrator.type = tried.integrator;
  EstimatedDynamics trial(quiet, buildTrial(quiet, full, tried.points));
  trial.estimateError();
  if (tried.membrane_share < 1.0) trial.softenMembrane(tried.membrane_share);
  const Index steps = std::max(Index{1}, static_cast<Index>(std::lround(params.duration / params.integrator.time_step)));
  const Index between = static_cast<Index>(static_cast<double>(tried.points) * steps / kMostKept) + 1;
  const bool is_static = params.integrator.type == solve::IntegratorType::kStatic;
  double apart = 0.0, estimate = 0.0;  // m, the largest so far
  Index implicit_steps = 0;
  solve::SolveReport taken;  // of the last sound step
  for (Index k = 1; k <= steps; ++k) {
    const EstimatedDynamics::Outcome outcome = trial.step();
    if (outcome.ok) taken = outcome.report;
    const Points& positions = trial.dynamics().state().positions;
    if (k % between == 0 && beside) {
      const Points& stated = beside->looks[k / between - 1];
      for (std::size_t i = 0; i < stated.size(); ++i) apart = std::max(apart, (positions[i] - stated[i]).norm());
    } else if (k % between == 0) {
      probe.looks.push_back(positions);
    }
    if (beside) probe.apart.push_back(apart);
    // Where the search for an equilibrium ended elsewhere, nothing is known of its error.
    const bool is_sound = outcome.ok && (!is_static || outcome.report.converged);
    const double now = is_sound ? trial.errorInRegions() : std::numeric_limits<double>::infinity();
    if (is_static && is_sound && k == 1 && !outcome.has_cut) probe.first_step = trial.keepFirstStep(outcome);
    if (now > estimate) probe.time_error = trial.timeError();
    estimate = std::max(estimate, now);
    probe.candidate.is_bounded = probe.candidate.is_bounded && is_sound && trial.estimator()->isBounded();
    probe.candidate.error = estimate + apart;
    probe.candidate.may_buckle = trial.estimator()->mayBuckle();
    probe.candidate.work += workOf(taken, tried.points, newtonWork(tried.points));
    if (taken.iterations > 0) ++implicit_steps;
    probe.is_implicit = 2 * implicit_steps > k;
    probe.spent = probe.candidate.work;
    probe.until = static_cast<double>(k) * params.integrator.time_step;
    probe.failed = probe.candidate.error > target;
    // More points may have a bound, if more can be tried.
    const double least = limits.hopeless > target ? findLeastError(probe.candidate) : probe.candidate.error;
    const bool is_hopeless = probe.failed && least > limits.hopeless;
    // An estimate of the work from fewer points can be too low. This trial knows it better.
    const double whole = probe.candidate.work * (static_cast<double>(steps) / k) * limits.whole_over_own;
    const bool is_affordable =
        probe.candidate.work <= limits.most_work || (limits.budget && limits.budget->allows(probe.candidate.work, whole));
    if (!is_hopeless && is_affordable) continue;
    if (k == steps && !is_hopeless) break;
    probe.is_cut = !probe.failed;
    // The cost of the full duration is still reported.
    probe.candidate.work *= static_cast<double>(steps) / k;
    probe.failed = true;
    return probe;
  }
  probe.is_whole = true;
  return probe;
}

}  // namespace deformable_surface::simulation
