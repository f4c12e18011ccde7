#include "accuracy_probe.h"

#include <algorithm>
#include <cmath>

#include "estimated_dynamics.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kMostKept = 2e6;  // points whose positions are kept of a probe: some fifty megabytes

// Cost of a Newton iteration over that of a Verlet sub-step, from 128 to 2048 points: between measurements on sheets, whose
// factors are sparser, and on spheres (docs/decisions/0006).
constexpr double kNewtonFactor = 3.8, kNewtonExponent = 0.8;
constexpr double kQuasiNewtonWork = 3.0;  // of an iteration, in passes of forces: 0.06 ms beside 0.02 with 400 points

// All trials together may take this share of the work of running all points once.
constexpr double kShareOfWhole = 1.0 / 3.0;
// A trial ends when it has taken more than this, about ten seconds of one core, and more than all trials before it.
constexpr double kMostWork = 1e8;

}  // namespace

double WorkBudget::left() const {
  const double all = std::max(free_, kShareOfWhole * whole_) - spent_;
  return std::max(0.0, std::min(all, std::max(kMostWork, spent_)));
}

double newtonWork(Index points) { return kNewtonFactor * std::pow(points, kNewtonExponent); }

Probe probeError(const SceneParams& params, const RestSurface& full, const AccuracyChoice::Candidate& tried, double target,
                 const Probe* beside, const ProbeLimits& limits) {
  Probe probe;
  probe.candidate = tried;
  SceneParams quiet = params;
  quiet.accuracy = AccuracyParams{};
  quiet.output.resample = false;
  quiet.integrator.type = tried.integrator;
  EstimatedDynamics trial(quiet, buildTrial(quiet, full, tried.points));
  trial.estimateError();
  if (tried.membrane_share < 1.0) trial.softenMembrane(tried.membrane_share);
  const Index steps = std::max(Index{1}, static_cast<Index>(std::lround(params.duration / params.integrator.time_step)));
  const Index between = static_cast<Index>(static_cast<double>(tried.points) * steps / kMostKept) + 1;
  double apart = 0.0;
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
    const double error = outcome.ok ? trial.bound() + apart : std::numeric_limits<double>::infinity();
    if (error > probe.candidate.error) probe.time_error = trial.timeError();
    probe.candidate.error = std::max(probe.candidate.error, error);
    probe.candidate.may_buckle = trial.estimator()->mayBuckle();
    const double iteration = taken.is_quasi_newton ? kQuasiNewtonWork : newtonWork(tried.points);
    const double substeps = taken.iterations > 0 ? iteration * taken.iterations : taken.substeps;
    probe.candidate.work += static_cast<double>(tried.points) * substeps;
    if (taken.iterations > 0) ++implicit_steps;
    probe.is_implicit = 2 * implicit_steps > k;
    probe.spent = probe.candidate.work;
    probe.until = static_cast<double>(k) * params.integrator.time_step;
    probe.failed = probe.candidate.error > target;
    const bool is_hopeless = probe.candidate.error > std::max(target, limits.hopeless);
    if (!is_hopeless && probe.candidate.work <= limits.most_work) continue;
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
