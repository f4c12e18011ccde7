#include "accuracy.h"

#include "accuracy_memory.h"
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

// The first membrane that is tried has this share of the stated stiffness, so that its steps take half as many sub-steps.
constexpr double kSofter = 0.25;
constexpr double kSoftest = 1.0 / 4096.0;
constexpr double kWorthwhile = 0.9;  // of the work: a softer membrane must save this, else bending or loads set the sub-steps

// Points times sub-steps that trials of clouds may take that are so small that nothing but all points is tried: whatever running
// them costs. What they save by a softer membrane or another integrator counts in later runs.
constexpr double kFreeWorkOfSmall = 2e7;
constexpr double kMostFirst = 1e8;  // of the first trial, before anything is known
// A choice that was not tried is of all points if these take no more than this in all, about two minutes of one core.
constexpr double kMostUntried = 1e9;
// More points than this share are not tried: the run would hardly cost less than one of all points, and the estimate is not
// calibrated there.
constexpr double kMostShare = 0.45;

// How the estimate falls with the number of points, estimate ~ points^-rate: as expected of one trial, and as far as it may be
// believed of two. The spacing h goes with points^-1/2; errors go with h^1 to h^2, mostly.
constexpr double kRate = 0.75, kLeastRate = 0.4, kLargestRate = 1.25;
constexpr double kAim = 0.7;          // of the target, so that the next trial probably meets it
constexpr double kLeastGrowth = 1.5;  // of the number of points from trial to trial
constexpr Index kBlindGrowth = 4;     // where a trial had no bound

// Cost of an explicit step by the number of points: the sub-steps grow with its root.
constexpr double kCostExponent = 1.5;
// The same beside tools, where contact sets the sub-steps: measured were 1.1 (530 to 1189 points of a gutter that a ball pushes).
constexpr double kCostExponentOfTools = 1.0;
constexpr int kTimedSteps = 5;  // of which the fastest counts: other work on the machine only makes steps slower
constexpr int kSettled = 25;    // steps of a probe that fits: the last ones are of a moving surface, whose sub-steps are finer

std::string sayPoints(Index points, Index of) { return std::to_string(points) + " of " + std::to_string(of) + " points"; }

// A softer membrane whose estimate stays below the target, and the distance of its probe from the one with the stated
// stiffness. What stretches more by a softer membrane does so in inverse proportion to the stiffness: the first trial tells how
// soft the second may be.
void chooseMembrane(const SceneParams& params, const RestSurface& full, const Probe& stated, WorkBudget& budget,
                    AccuracyChoice& choice) {
  const double target = params.accuracy.position_error;
  double apart = 0.0;  // m, of the last trial
  const auto isBetter = [&](double share) {
    Candidate tried = stated.candidate;
    tried.error = tried.work = 0.0;
    tried.membrane_share = share;
    if (stated.candidate.work * std::sqrt(share) > budget.left()) return false;
    Probe probe = probeError(params, full, tried, target, &stated, {budget.left()});
    budget.spend(probe.spent);
    choice.candidates.push_back(probe.candidate);
    apart = probe.apart.empty() ? 0.0 : probe.apart.back();
    if (probe.failed || !(probe.candidate.work < kWorthwhile * choice.work)) return false;
    choice.take(probe.candidate);
    choice.softening = std::move(probe.apart);
    return true;
  };
  if (!isBetter(kSofter)) {
    if (apart > 0.0) isBetter(std::sqrt(kSofter));  // half way back
    return;
  }
  const double room = kAim * (target - stated.candidate.error), each = apart / (1.0 / kSofter - 1.0);
  const double softest = std::max(kSoftest, each > 0.0 ? each / (each + std::max(0.0, room)) : kSoftest);
  if (softest < kWorthwhile * kWorthwhile * kSofter && !isBetter(softest)) isBetter(std::sqrt(softest * kSofter));
}

// The number of points whose estimate is expected at the target, by trials of fewer: not finite without a bound.
double predictPoints(const std::vector<Probe>& trials, double target) {
  const Candidate& last = trials.back().candidate;
  if (!std::isfinite(last.error)) return std::numeric_limits<double>::infinity();
  double rate = kRate;
  if (trials.size() > 1) {
    const Candidate& before = trials[trials.size() - 2].candidate;
    const double found = std::log(before.error / last.error) / std::log(static_cast<double>(last.points) / before.points);
    if (std::isfinite(found)) rate = std::min(kLargestRate, std::max(kLeastRate, found));
  }
  return last.points * std::max(kLeastGrowth, std::pow(last.error / target, 1.0 / rate));
}

// The fewest points whose estimate stays below the target, as far as trials pay.
class ChoiceByError {
 public:
  ChoiceByError(const SceneParams& params, const RestSurface& full, AccuracyChoice& choice)
      : params_(params),
        full_(full),
        choice_(choice),
        n_(static_cast<Index>(full.dense.positions.size())),
        target_(params.accuracy.position_error),
        most_(static_cast<Index>(kMostShare * n_)),
        budget_(isSmall() ? kFreeWorkOfSmall : 0.0) {}

  Index choose() {
    asked_ = "accuracy.position_error " + formatReal(target_) + " m: ";
    if (isSmall()) {
      chooseAll();
    } else {
      Index points = kFewestTried;
      while (!isMetBy(points)) {
        const Index next = findNext();
        if (next == 0) {
          chooseUntried();
          break;
        }
        points = next;
      }
    }
    if (choice_.may_buckle) choice_.sentence += "; it may buckle, so that another run may end elsewhere";
    return choice_.points;
  }

 private:
  // The fewest points that are tried are nearly all of them.
  bool isSmall() const { return most_ < kFewestTried; }
  bool isStatic() const { return params_.integrator.type == IntegratorType::kStatic; }

  Probe attempt(Index points, double most_work) {
    Candidate tried;
    tried.points = points;
    tried.integrator = params_.integrator.type;
    // Even if it falls as fast as errors do, an estimate above this is not below the target with the most points to try.
    const double hopeless = target_ * std::pow(std::max(1.0, static_cast<double>(most_) / points), kLargestRate);
    Probe probe = probeError(params_, full_, tried, target_, nullptr, {most_work, hopeless});
    budget_.spend(probe.spent);
    choice_.candidates.push_back(probe.candidate);
    budget_.learnWhole(expectWork(probe, n_));
    return probe;
  }

  double costExponent() const { return params_.tools.empty() ? kCostExponent : kCostExponentOfTools; }

  // Of so many points, by a trial of fewer. An equilibrium costs the most in its first step.
  double expectWork(const Probe& by, double points) const {
    const double work = isStatic() && !by.is_whole ? by.spent : by.candidate.work;
    return work * std::pow(points / by.candidate.points, costExponent());
  }

  // A trial; what meets the target is chosen, and improved.
  bool isMetBy(Index points) {
    trials_.push_back(attempt(points, trials_.empty() ? kMostFirst : budget_.left()));
    return takeIfMet(trials_.back());
  }

  bool takeIfMet(Probe& probe) {
    if (probe.failed && !probe.is_cut && mayChooseIntegrator(params_)) tryVerlet(params_, full_, budget_, probe, choice_);
    if (probe.failed) return false;
    choice_.take(probe.candidate);
    choice_.is_met = true;
    if (findModel(params_.model).maySoften(params_)) chooseMembrane(params_, full_, probe, budget_, choice_);
    if (mayChooseIntegrator(params_)) chooseIntegrator(params_, full_, budget_, probe, choice_);
    choice_.sentence = asked_ + sayPoints(choice_.points, n_) +
                       (choice_.points < n_ ? " simulated, the fewest tried whose" : " simulated, whose") +
                       " estimated error over " + formatReal(params_.duration) + " s stays below it (" + sayEstimate() + ")";
    if (choice_.membrane_share < 1.0)
      choice_.sentence += ", with " + formatReal(choice_.membrane_share) +
                          " of the stated membrane stiffness, for which that holds, too (sub-steps are fewer)";
    if (!choice_.why_integrator.empty()) choice_.sentence += "; " + choice_.why_integrator;
    return true;
  }

  // The next number to try; 0: none pays.
  Index findNext() const {
    const Probe& last = trials_.back();
    if (last.is_cut || last.candidate.points >= most_) return 0;
    // An estimate that was given up while it grew is larger than it was found.
    if (!last.is_whole && std::isfinite(last.candidate.error)) return 0;
    const double affordable = std::pow(budget_.left() / expectWork(last, last.candidate.points), 1.0 / costExponent());
    const double largest = std::min(static_cast<double>(most_), affordable * last.candidate.points);
    double next = predictPoints(trials_, target_);
    if (std::isfinite(next) && next <= largest) {
      next = std::min(largest, predictPoints(trials_, kAim * target_));
    } else if (!std::isfinite(next)) {
      // Where a bound ends before points are close enough, nothing tells how close that is.
      next = static_cast<double>(kBlindGrowth) * last.candidate.points;
    }
    return next <= largest ? static_cast<Index>(next) : 0;
  }

  // All points, tried if that costs next to nothing.
  void chooseAll() {
    Probe probe = attempt(n_, budget_.left());
    if (takeIfMet(probe)) return;
    trials_.push_back(std::move(probe));
    takeUntried(n_);
  }

  // More points than were tried.
  void chooseUntried() {
    const bool is_known = isStatic() || budget_.whole() > budget_.left();  // what a trial of all points would find, or too dear
    if (!is_known) {
      chooseAll();
    } else if (budget_.whole() <= kMostUntried) {
      takeUntried(n_);
    } else {
      const Probe& last = trials_.back();
      if (last.is_cut) return takeUntried(last.candidate.points);
      const double expected = predictPoints(trials_, kAim * target_);
      takeUntried(expected < n_ ? static_cast<Index>(expected) : std::isfinite(expected) ? n_ : trials_.back().candidate.points);
    }
  }

  // With all points there is no error but that of the steps, which sound trials of fewer know: their steps are longer.
  void takeUntried(Index points) {
    const Probe& last = trials_.back();
    const bool is_all = points == n_, has_missed = last.candidate.points == n_ && !last.is_cut;
    const bool is_steps_known = is_all && !has_missed && std::isfinite(last.candidate.error) && (isStatic() || !last.is_implicit);
    const double steps_error = isStatic() ? 0.0 : last.time_error;  // m
    choice_.take(last.candidate);
    choice_.points = points;
    choice_.integrator = params_.integrator.type;
    choice_.work = last.candidate.work * std::pow(static_cast<double>(points) / last.candidate.points, costExponent());
    choice_.is_met = is_steps_known && (isStatic() || last.is_whole) && steps_error <= target_;
    const std::string trial = "the trial of " + std::to_string(last.candidate.points) + " points ended";
    if (is_steps_known && steps_error <= target_) {
      choice_.error = steps_error;
      choice_.sentence = asked_ + "all " + std::to_string(n_) +
                         " points simulated, as trials of fewer that meet it would cost more than they save; the error of the "
                         "steps is estimated at " +
                         formatShort(steps_error) + " m";
      if (!choice_.is_met) choice_.sentence += " over the first " + formatShort(last.until) + " s, where " + trial;
    } else if (is_all) {
      choice_.sentence = asked_ +
                         "cannot be met for certain even with every point simulated, which is chosen; the estimated error was " +
                         sayEstimate() + " where " + trial;
    } else if (points == last.candidate.points) {
      choice_.sentence = asked_ + (last.is_cut ? "not known to be met by " : "not met by ") + sayPoints(points, n_) +
                         ", the most whose trial is affordable, which are chosen; its estimated error was " + sayEstimate() +
                         " after " + formatShort(last.until) + " s, where the trial ended";
    } else {
      choice_.sentence = asked_ + sayPoints(points, n_) + " simulated, as many as it probably takes by trials of up to " +
                         std::to_string(last.candidate.points) + " points; no trial of as many is affordable";
    }
  }

  std::string sayEstimate() const { return std::isfinite(choice_.error) ? formatShort(choice_.error) + " m" : "not bounded"; }

  const SceneParams& params_;
  const RestSurface& full_;
  AccuracyChoice& choice_;
  const Index n_;
  const double target_;  // m
  const Index most_;     // to try, except all
  WorkBudget budget_;
  std::string asked_;
  std::vector<Probe> trials_;
};

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
  std::string kept;  // about the memory, for the user
  RestSurface rest = build([&](const RestSurface& full) {
    if (params.accuracy.position_error > 0.0) {
      const ChoiceMemory memory(params, full);
      if (memory.recall(choice)) {
        kept = "no trials: what an earlier run of this scene chose was kept (accuracy.remember)";
        return choice.points;
      }
      ChoiceByError(params, full, choice).choose();
      if (memory.isOn())
        kept = (memory.keep(choice) ? "what trials chose is kept for later runs in " : "what trials chose cannot be kept in ") +
               findCacheFolder() + " (accuracy.remember)";
      return choice.points;
    }
    return chooseByBudget(params, full, choice);
  });
  if (!kept.empty()) rest.notes.push_back(kept);
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
