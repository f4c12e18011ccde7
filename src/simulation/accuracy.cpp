#include "accuracy.h"

#include "accuracy_probe.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/base/value.h"
#include "estimated_dynamics.h"
#include "integrator_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace deformable_surface::simulation {
namespace {

using Candidate = AccuracyChoice::Candidate;
using solve::IntegratorType;

// Each membrane that is tried has this share of the stiffness of the one before, so that its steps take half as many
// sub-steps.
constexpr double kSofter = 0.25;
constexpr double kWorthwhile = 0.9;  // of the work: a softer membrane must save this, else bending or loads set the sub-steps
// Points times sub-steps of a probe, about ten seconds of one core. A finer probe is not begun if it would take more than this
// and more than all probes before it.
constexpr double kMostWork = 1e8;
// For clouds of up to this many points, all points are tried after the smallest number, for two seconds at most. That replaces
// guesses.
constexpr Index kSmall = 8 * kFewestTried;
constexpr double kMostWorkOfSmall = 2e7;
// Cost of an explicit step by the number of points: the sub-steps grow with its root.
constexpr double kCostExponent = 1.5;
constexpr int kTimedSteps = 5;  // of which the fastest counts: other work on the machine only makes steps slower
constexpr int kSettled = 25;    // steps of a probe that fits: the last ones are of a moving surface, whose sub-steps are finer

std::string sayPoints(Index points, Index of) { return std::to_string(points) + " of " + std::to_string(of) + " points"; }

// The softest membrane whose estimate stays below the target, and the distance of its probe from the one with the stated
// stiffness.
void chooseMembrane(const SceneParams& params, const RestSurface& full, const Probe& stated, AccuracyChoice& choice) {
  const auto isBetter = [&](double share) {
    Candidate tried = stated.candidate;
    tried.error = tried.work = 0.0;
    tried.membrane_share = share;
    Probe probe = probeError(params, full, tried, params.accuracy.position_error, &stated);
    choice.candidates.push_back(probe.candidate);
    if (probe.failed || !(probe.candidate.work < kWorthwhile * choice.work)) return false;
    choice.take(probe.candidate);
    choice.softening = std::move(probe.apart);
    return true;
  };
  double share = kSofter;
  while (isBetter(share)) share *= kSofter;
  isBetter(share / std::sqrt(kSofter));  // half way back
}

// Trials of increasing numbers of points.
class Ladder {
 public:
  Ladder(const SceneParams& params, const RestSurface& full, AccuracyChoice& choice)
      : params_(params), full_(full), choice_(choice), n_(static_cast<Index>(full.dense.positions.size())) {}

  Index size() const { return n_; }

  /// Whether a trial of so many points is affordable after this one, by an extrapolation. For an equilibrium the first step costs
  /// the most; else every step costs about the same.
  bool canAfford(Index points, const Probe& last) {
    if (n_ <= kSmall && points < n_ && !has_tried_all_) tryAll();
    if (points == n_ && is_all_known_) return true;
    const double work = isStatic() ? last.spent : last.candidate.work;
    return work * std::pow(static_cast<double>(points) / last.candidate.points, kCostExponent) <= grant();
  }

  /// A trial of so many points. A trial of an equilibrium ends when it is no longer affordable.
  Probe take(Index points) {
    if (points == n_ && is_all_known_) return std::move(all_);
    return attempt(points, isStatic() ? grant() : std::numeric_limits<double>::infinity());
  }

 private:
  bool isStatic() const { return params_.integrator.type == IntegratorType::kStatic; }
  double grant() const { return std::max(kMostWork, spent_); }

  void tryAll() {
    has_tried_all_ = true;
    Probe probe = attempt(n_, kMostWorkOfSmall);
    is_all_known_ = !probe.is_cut;
    if (is_all_known_) all_ = std::move(probe);
  }

  Probe attempt(Index points, double most_work) {
    Candidate tried;
    tried.points = points;
    tried.integrator = params_.integrator.type;
    Probe probe = probeError(params_, full_, tried, params_.accuracy.position_error, nullptr, most_work);
    choice_.candidates.push_back(probe.candidate);
    spent_ += probe.spent;
    return probe;
  }

  const SceneParams& params_;
  const RestSurface& full_;
  AccuracyChoice& choice_;
  const Index n_;
  bool has_tried_all_ = false, is_all_known_ = false;
  Probe all_;           // of all points, if it is known already
  double spent_ = 0.0;  // work of all trials so far
};

// The fewest points whose estimate stays below the target.
Index chooseByError(const SceneParams& params, const RestSurface& full, AccuracyChoice& choice) {
  Ladder ladder(params, full, choice);
  const Index n = ladder.size();
  const double target = params.accuracy.position_error;
  const std::string asked = "accuracy.position_error " + formatReal(target) + " m: ";
  for (Index points = std::min(kFewestTried, n);; points = std::min(2 * points, n)) {
    Probe probe = ladder.take(points);
    const bool is_affordable = !probe.is_cut || points == kFewestTried;
    if (is_affordable) {
      if (probe.failed && mayChooseIntegrator(params)) tryVerlet(params, full, probe, choice);
      choice.take(probe.candidate);
      choice.is_met = !probe.failed;
      if (choice.is_met && findModel(params.model).maySoften(params)) chooseMembrane(params, full, probe, choice);
      if (choice.is_met && mayChooseIntegrator(params)) chooseIntegrator(params, full, probe, choice);
    }
    const std::string estimate = std::isfinite(choice.error) ? formatShort(choice.error) + " m" : "infinite";
    if (choice.is_met) {
      choice.sentence = asked + sayPoints(points, n) + " simulated, the fewest tried whose estimated error over " +
                        formatReal(params.duration) + " s stays below it (" + estimate + ")";
      if (choice.membrane_share < 1.0)
        choice.sentence += ", with " + formatReal(choice.membrane_share) +
                           " of the stated membrane stiffness, the least tried for which that holds (sub-steps are fewer)";
      if (!choice.why_integrator.empty()) choice.sentence += "; " + choice.why_integrator;
      break;
    }
    const std::string reached = "; its estimated error was " + estimate + " where the trial ended";
    if (is_affordable && points == n) {
      choice.sentence = asked + "cannot be met even with every point simulated, which is chosen" + reached;
      break;
    }
    if (!is_affordable || !ladder.canAfford(std::min(2 * points, n), probe)) {
      choice.sentence = asked + "not met by " + sayPoints(choice.points, n) +
                        ", the most whose trial is affordable, which are chosen" + reached;
      break;
    }
  }
  if (choice.may_buckle) choice.sentence += "; it may buckle, so that another run may end elsewhere";
  return choice.points;
}

// Time of a step of the probe, s; taken: the integrator used.
double timeProbe(const SceneParams& params, const RestSurface& full, Index points, IntegratorType type, IntegratorType& taken) {
  SceneParams quiet = params;
  quiet.integrator.type = type;
  quiet.accuracy = AccuracyParams{};
  quiet.sleep.mode = Sleep::kNever;  // to time a surface in motion
  quiet.output.resample = false;
  EstimatedDynamics trial(quiet, buildTrial(quiet, full, points));
  if (params.accuracy.estimate && trial.dynamics().kind().traits().has_estimate) trial.estimateError();
  const auto step = [&] {
    const Timer timer;
    return trial.step().ok ? timer.seconds() : std::numeric_limits<double>::infinity();
  };
  const double seconds = timeSteps(step, params.accuracy.step_budget);
  taken = trial.dynamics().lastIntegrator();
  return seconds;
}

// The most points whose step fits, with auto's integrator or with the other one if that leads to a smaller estimate.
Index chooseByBudget(const SceneParams& params, const RestSurface& full, AccuracyChoice& choice) {
  const Index n = static_cast<Index>(full.dense.positions.size());
  IntegratorType taken = IntegratorType::kVerlet;
  const auto time_with = [&](IntegratorType type) {
    return [&, type](Index points) { return timeProbe(params, full, points, type, taken); };
  };
  chooseByTime(n, params.accuracy.step_budget, time_with(params.integrator.type), choice);
  const bool has_all = choice.is_met && choice.points == n && taken == IntegratorType::kVerlet;
  if (has_all || !mayChooseIntegrator(params)) return choice.points;
  const IntegratorType other = taken == IntegratorType::kVerlet ? IntegratorType::kImplicit : IntegratorType::kVerlet;
  AccuracyChoice with_other;
  chooseByTime(n, params.accuracy.step_budget, time_with(other), with_other);
  compareIntegrators(params, full, other, with_other, choice);
  return choice.points;
}

}  // namespace

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

namespace {

// build: makes the surface with the function that chooses, or with none.
RestSurface buildChosenBy(const std::function<RestSurface(const ModelKind::Choose&)>& build, const SceneParams& params,
                          AccuracyChoice& choice) {
  choice = AccuracyChoice{};
  choice.is_asked = hasTarget(params.accuracy);
  if (!choice.is_asked) return build(nullptr);
  RestSurface rest = build([&](const RestSurface& full) {
    if (params.accuracy.position_error > 0.0) return chooseByError(params, full, choice);
    return chooseByBudget(params, full, choice);
  });
  rest.notes.push_back(choice.sentence);
  return rest;
}

}  // namespace

RestSurface buildChosen(const SceneParams& params, const cloud::PointCloud& input, AccuracyChoice& choice) {
  const auto build = [&](const ModelKind::Choose& choose) {
    return buildRestSurface(params, input, findCoarsest(params), choose);
  };
  return buildChosenBy(build, params, choice);
}

RestSurface buildChosen(const SceneParams& params, RestSurface prepared, AccuracyChoice& choice) {
  const auto build = [&](const ModelKind::Choose& choose) { return buildRestSurface(params, std::move(prepared), choose); };
  return buildChosenBy(build, params, choice);
}

}  // namespace deformable_surface::simulation
