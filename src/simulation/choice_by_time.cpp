#include "choice_by_time.h"

#include "deformable_surface/base/timer.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "estimated_dynamics.h"
#include "integrator_choice.h"

namespace deformable_surface::simulation {
namespace {

using Candidate = AccuracyChoice::Candidate;
using solve::IntegratorType;

constexpr double kCostExponent = 1.5;  // of a step by the number of points: the sub-steps of explicit ones grow with its root
constexpr int kTimedSteps = 5;         // of which the fastest counts: other work on the machine only makes steps slower
constexpr int kSettled = 25;  // steps of a probe that fits: the last ones are of a moving surface, whose sub-steps are finer

// Time of a step of the probe, s; taken: the integrator used.
double timeProbe(const SceneParams& params, const RestSurface& full, Index points, IntegratorType type, IntegratorType& taken) {
  SceneParams quiet = params;
  quiet.integrator.type = type;
  quiet.accuracy = AccuracyParams{};
  quiet.sleep.mode = Sleep::kNever;  // to time a surface in motion
  quiet.output.resample = quiet.output.error = false;
  EstimatedDynamics trial(quiet, buildTrial(quiet, full, points));
  if (params.accuracy.estimate && trial.dynamics().kind().refuseEstimate(params).empty()) trial.estimateError();
  const auto step = [&] {
    const Timer timer;
    return trial.step().ok ? timer.seconds() : std::numeric_limits<double>::infinity();
  };
  const double seconds = timeSteps(step, params.accuracy.step_budget);
  taken = trial.dynamics().lastIntegrator();
  return seconds;
}

}  // namespace

void chooseByBudget(const SceneParams& params, const RestSurface& full, AccuracyChoice& choice) {
  const Index n = static_cast<Index>(full.dense.positions.size());
  IntegratorType taken = IntegratorType::kVerlet;
  const auto time_with = [&](IntegratorType type) {
    return [&, type](Index points) { return timeProbe(params, full, points, type, taken); };
  };
  chooseByTime(n, params.accuracy.step_budget, time_with(params.integrator.type), choice);
  const bool has_all = choice.is_met && choice.points == n && taken == IntegratorType::kVerlet;
  if (has_all || !mayChooseIntegrator(params)) return;
  const IntegratorType other = taken == IntegratorType::kVerlet ? IntegratorType::kImplicit : IntegratorType::kVerlet;
  AccuracyChoice with_other;
  chooseByTime(n, params.accuracy.step_budget, time_with(other), with_other);
  compareIntegrators(params, full, other, with_other, choice);
}

double timeSteps(const std::function<double()>& step, double budget) {
  std::array<double, kTimedSteps> last;
  last.fill(std::numeric_limits<double>::infinity());
  double spent = 0.0;
  for (int k = 0; k <= kTimedSteps || (k < kSettled && spent < kSettled * budget); ++k) {
    const double seconds = step();
    if (!std::isfinite(seconds)) return seconds;
    if (k == 0) continue;  // it also builds what later steps reuse
    last[k % kTimedSteps] = seconds;
    spent += seconds;
  }
  return *std::min_element(last.begin(), last.end());
}

Index chooseByTime(Index n, double budget, const std::function<double(Index)>& time_step, AccuracyChoice& choice) {
  const auto attempt = [&](Index points) {
    choice.candidates.push_back({points, 0.0, time_step(points)});
    return choice.candidates.back().step_time;
  };
  Candidate best;
  for (Index points = std::min(kFewestTried, n);; points = std::min(2 * points, n)) {
    const double seconds = attempt(points);
    if (seconds <= budget) best = choice.candidates.back();
    if (!(seconds <= budget) || points == n) break;
  }
  const std::string asked = "accuracy.step_budget " + formatReal(budget) + " s: ";
  const std::string warning = "; choosing by wall time gives up bit-identical repeats";
  choice.is_met = best.points > 0;
  if (!choice.is_met) {
    const Candidate& fewest = choice.candidates.front();
    choice.points = fewest.points;
    choice.sentence = asked + "cannot be met; the fewest tried, " + sayPoints(fewest.points, n) + ", take " +
                      formatReal(fewest.step_time) + " s per step and are chosen" + warning;
    return choice.points;
  }
  // Between the last that fits and the first that does not, by the growth of the cost.
  const Index between = static_cast<Index>(best.points * std::pow(budget / best.step_time, 1.0 / kCostExponent));
  if (best.points < n && between > best.points && attempt(std::min(between, n)) <= budget) best = choice.candidates.back();
  choice.points = best.points;
  choice.sentence = asked + sayPoints(best.points, n) + " simulated, the most tried whose step fits (" +
                    formatReal(best.step_time) + " s)" + warning;
  return choice.points;
}

}  // namespace deformable_surface::simulation
