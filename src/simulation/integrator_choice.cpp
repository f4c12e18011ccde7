#include "integrator_choice.h"

#include "deformable_surface/base/value.h"
#include "deformable_surface/simulation/model_kind.h"

#include <algorithm>
#include <cmath>

#include "step_work.h"

namespace deformable_surface::simulation {
namespace {

using Candidate = AccuracyChoice::Candidate;
using solve::IntegratorType;

constexpr double kWorthwhile = 0.9;     // of the work: another integrator must save this
constexpr double kLeastIterations = 1;  // of an implicit step: slow motion takes few more

constexpr double kComparedSteps = 200;  // a trial of two budgets' steps: a second at a budget of two milliseconds

const char* nameOf(IntegratorType type) { return type == IntegratorType::kImplicit ? "implicit" : "verlet"; }

}  // namespace

bool mayChooseIntegrator(const SceneParams& params) {
  return params.integrator.type == IntegratorType::kAuto && findModel(params.model).traits().is_tuned;
}

void tryVerlet(const SceneParams& params, const RestSurface& full, WorkBudget& budget, Probe& failed, AccuracyChoice& choice) {
  const double target = params.accuracy.position_error;
  const Candidate& implicit = failed.candidate;
  if (!failed.is_implicit || !(implicit.error - failed.time_error <= target)) return;
  // Auto left Verlet because its sub-steps are more than this.
  const double steps = std::round(params.duration / params.integrator.time_step);
  if (steps * params.integrator.max_substeps * implicit.points > budget.left()) return;
  Candidate tried;
  tried.points = failed.candidate.points;
  tried.integrator = IntegratorType::kVerlet;
  Probe probe = probeError(params, full, tried, target, nullptr, {budget.left()});
  budget.spend(probe.spent);
  choice.candidates.push_back(probe.candidate);
  if (probe.failed || !probe.candidate.is_bounded) return;
  choice.why_integrator = "with verlet's sub-steps, though they are more than integrator.max_substeps " +
                          std::to_string(params.integrator.max_substeps) + ": implicit steps damp by more than the target";
  failed = std::move(probe);
}

void chooseIntegrator(const SceneParams& params, const RestSurface& full, WorkBudget& budget, const Probe& first,
                      AccuracyChoice& choice) {
  if (choice.integrator != IntegratorType::kAuto) return;
  const bool was_softened = choice.membrane_share < 1.0;
  Candidate tried;
  tried.points = choice.points;
  tried.integrator = first.is_implicit && !was_softened ? IntegratorType::kVerlet : IntegratorType::kImplicit;
  const double steps = std::round(params.duration / params.integrator.time_step), worthwhile = kWorthwhile * choice.work;
  const bool to_implicit = tried.integrator == IntegratorType::kImplicit;
  const double least = steps * kLeastIterations * tried.points * newtonWork(tried.points);
  if (to_implicit && (least > worthwhile || first.is_implicit)) return;  // without Verlet's steps there is nothing to measure by
  const Probe* beside = to_implicit ? &first : nullptr;
  if (to_implicit && least > budget.left()) return;
  Probe probe = probeError(params, full, tried, params.accuracy.position_error, beside, {std::min(budget.left(), worthwhile)});
  budget.spend(probe.spent);
  choice.candidates.push_back(probe.candidate);
  if (probe.failed || !probe.candidate.is_bounded) return;
  choice.why_integrator = std::string("integrator ") + nameOf(tried.integrator) + ", whose trial took " +
                          formatShort(probe.candidate.work / choice.work) + " of the work of " +
                          (was_softened        ? "verlet's with a softer membrane"
                           : first.is_implicit ? "implicit steps"
                                               : "verlet's sub-steps");
  choice.take(probe.candidate);
  choice.softening = std::move(probe.apart);
}

void compareIntegrators(const SceneParams& params, const RestSurface& full, IntegratorType other, AccuracyChoice& with_other,
                        AccuracyChoice& choice) {
  for (Candidate& candidate : with_other.candidates) {
    candidate.integrator = other;
    choice.candidates.push_back(candidate);
  }
  // With fewer points, damping steps are no better, and coarser copies could miss their errors where tools touch.
  if (!with_other.is_met) return;
  if (choice.is_met && other == IntegratorType::kImplicit && !params.tools.empty()) return;
  if (choice.is_met && other == IntegratorType::kImplicit && with_other.points <= choice.points) return;
  with_other.why_integrator = std::string("integrator ") + nameOf(other);
  if (choice.is_met) {
    SceneParams beginning = params;
    beginning.duration = std::min(params.duration, kComparedSteps * params.integrator.time_step);
    const auto estimate = [&](Index points, IntegratorType type) {
      Candidate tried;
      tried.points = points;
      tried.integrator = type;
      choice.candidates.push_back(probeError(beginning, full, tried, std::numeric_limits<double>::infinity()).candidate);
      const Candidate& found = choice.candidates.back();
      return found.is_bounded ? found.error : std::numeric_limits<double>::infinity();
    };
    const double error = estimate(choice.points, IntegratorType::kAuto), error_of_other = estimate(with_other.points, other);
    if (!(error_of_other < error)) return;
    with_other.why_integrator += ", whose estimated error over " + formatReal(beginning.duration) + " s is " +
                                 formatReal(error_of_other) + " m; with what auto takes and " + std::to_string(choice.points) +
                                 " points it is " + formatReal(error) + " m";
  } else {
    with_other.why_integrator += ", as what auto takes does not fit";
  }
  with_other.integrator = other;
  with_other.is_asked = choice.is_asked;
  with_other.candidates = std::move(choice.candidates);
  with_other.sentence += "; " + with_other.why_integrator;
  choice = std::move(with_other);
}

}  // namespace deformable_surface::simulation
