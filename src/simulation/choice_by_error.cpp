#include "choice_by_error.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/simulation/model_kind.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "accuracy_probe.h"
#include "integrator_choice.h"
#include "membrane_choice.h"

namespace deformable_surface::simulation {
namespace {

using Candidate = AccuracyChoice::Candidate;
using solve::IntegratorType;

// Points times sub-steps that trials of clouds may take that are so small that nothing but all points is tried: whatever running
// them costs. What they save by a softer membrane or another integrator counts in later runs.
constexpr double kFreeWorkOfSmall = 2e7;
// A choice that was not tried is of all points if these take no more than this in all, about two minutes of one core.
constexpr double kMostUntried = 1e9;
// More points than this share are not tried: the run would hardly cost less than one of all points, and the estimate is not
// calibrated there.
constexpr double kMostShare = 0.45;

// How the estimate falls with the number of points, estimate ~ points^-rate: as expected of one trial, and as far as it may be
// believed of two. The spacing h goes with points^-1/2; errors go with h^1 to h^2, mostly.
constexpr double kRate = 0.75, kLeastRate = 0.4, kLargestRate = 1.25;
constexpr double kAim = 0.7;          // of the target, so that the next trial probably meets it
constexpr double kLeastGrowth = 1.5;  // of the number of points from trial to trial, where so many may be tried
constexpr Index kBlindGrowth = 4;     // where a trial had no estimate

// How the work grows with the number of points, work ~ points^exponent: the sub-steps of explicit steps grow with its root.
// Beside tools contact sets the sub-steps, too: 1.05 to 1.5 in sixteen scenes.
constexpr double kCostExponent = 1.5, kCostExponentOfTools = 1.25;
// As far as two trials may be believed.
constexpr double kLeastCostExponent = 1.0, kLargestCostExponent = 1.5;

// The number of points whose error is expected at the target, by trials of fewer: not finite where these say nothing.
double predictPoints(const std::vector<Probe>& trials, double target) {
  const Candidate& last = trials.back().candidate;
  const double error = findLeastError(last);
  if (!std::isfinite(error)) return std::numeric_limits<double>::infinity();
  double rate = kRate;
  if (trials.size() > 1) {
    const Candidate& before = trials[trials.size() - 2].candidate;
    const double found = std::log(findLeastError(before) / error) / std::log(static_cast<double>(last.points) / before.points);
    if (std::isfinite(found)) rate = std::min(kLargestRate, std::max(kLeastRate, found));
  }
  return last.points * std::max(1.0, std::pow(error / target, 1.0 / rate));
}

// The fewest points whose expected error stays below the target, as far as trials pay.
class ChoiceByError {
 public:
  ChoiceByError(const SceneParams& params, const RestSurface& full, AccuracyChoice& choice, double most_first)
      : params_(params),
        full_(full),
        choice_(choice),
        n_(static_cast<Index>(full.dense.positions.size())),
        target_(params.accuracy.position_error),
        most_first_(most_first),
        most_(static_cast<Index>(kMostShare * n_)),
        budget_(isSmall() ? kFreeWorkOfSmall : 0.0) {}

  void choose() {
    asked_ = "accuracy.position_error " + formatReal(target_) + " m" + countPlaces() + ": ";
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
    if (choice_.may_buckle) {
      const bool is_tried = trials_.empty() || trials_.back().candidate.points == choice_.points;
      choice_.sentence +=
          is_tried ? "; it may buckle, so that another run may end elsewhere" : "; with the points of that trial it may buckle";
    }
  }

 private:
  // How many points of the cloud the target counts at, in words. InputError if a region holds none.
  std::string countPlaces() const {
    if (params_.accuracy.regions.empty()) return "";
    const Points& cloud = full_.dense.positions;
    for (std::size_t r = 0; r < params_.accuracy.regions.size(); ++r) {
      const geometry::Region& region = params_.accuracy.regions[r].region;
      if (std::none_of(cloud.begin(), cloud.end(), [&](const Vec3& p) { return region.contains(p); }))
        throw InputError("accuracy.regions[" + std::to_string(r) + "]: the shape holds none of the " + std::to_string(n_) +
                         " points at rest; accepted: a shape that holds at least one");
    }
    const auto counts = std::count_if(cloud.begin(), cloud.end(), [&](const Vec3& p) { return isInTarget(params_.accuracy, p); });
    return " in accuracy.regions, which hold " + std::to_string(counts) + " of the cloud's points";
  }

  // The fewest points that are tried are nearly all of them.
  bool isSmall() const { return most_ < kFewestTried; }
  bool isStatic() const { return params_.integrator.type == IntegratorType::kStatic; }

  Probe attempt(Index points, double most_work) {
    Candidate tried;
    tried.points = points;
    tried.integrator = params_.integrator.type;
    // Even if it falls as fast as errors do, an error above this is not below the target with the most points to try next.
    const double hopeless = target_ * std::pow(findLargestGrowth(points), kLargestRate);
    ProbeLimits limits{most_work, hopeless};
    // The first trial has a limit of its own, and the first step of an equilibrium does not tell what the others cost.
    if (!trials_.empty() && !isStatic()) limits.budget = &budget_;
    limits.whole_over_own = std::pow(static_cast<double>(n_) / points, costExponent());
    Probe probe = probeError(params_, full_, tried, target_, nullptr, limits);
    budget_.spend(probe.spent);
    choice_.candidates.push_back(probe.candidate);
    return probe;
  }

  // How many times as many points can still be tried after a trial of this many; 1: none.
  double findLargestGrowth(Index points) const {
    // Work in that of this trial.
    const double whole = std::pow(static_cast<double>(n_) / points, costExponent());
    const double spent = trials_.empty() ? 0.0 : budget_.spent() / expectWork(trials_.back(), points);
    const double affordable = std::pow(std::max(0.0, kShareOfWhole * whole - spent - 1.0), 1.0 / costExponent());
    const double growth = std::min(affordable, static_cast<double>(most_) / points);
    return growth < kLeastGrowth ? 1.0 : growth;
  }

  double costExponent() const {
    const double expected = params_.tools.empty() ? kCostExponent : kCostExponentOfTools;
    if (trials_.size() < 2) return expected;
    const Probe &last = trials_.back(), &before = trials_[trials_.size() - 2];
    if (!last.is_whole || !before.is_whole) return expected;
    const double found = std::log(last.candidate.work / before.candidate.work) /
                         std::log(static_cast<double>(last.candidate.points) / before.candidate.points);
    return std::isfinite(found) ? std::min(kLargestCostExponent, std::max(kLeastCostExponent, found)) : expected;
  }

  // Of so many points, by a trial of fewer. An equilibrium costs the most in its first step.
  double expectWork(const Probe& by, double points) const {
    const double work = isStatic() && !by.is_whole ? by.spent : by.candidate.work;
    return work * std::pow(points / by.candidate.points, costExponent());
  }

  // A trial; what meets the target is chosen, and improved.
  bool isMetBy(Index points) {
    trials_.push_back(attempt(points, trials_.empty() ? most_first_ : budget_.left()));
    budget_.learnWhole(expectWork(trials_.back(), n_));
    return takeIfMet(trials_.back());
  }

  bool takeIfMet(Probe& probe) {
    if (probe.failed && !probe.is_cut && mayChooseIntegrator(params_)) tryVerlet(params_, full_, budget_, probe, choice_);
    if (probe.failed) return false;
    choice_.take(probe.candidate);
    choice_.first_step = probe.first_step;
    choice_.is_met = probe.candidate.is_bounded;
    if (!choice_.is_met) {
      choice_.sentence = asked_ + "probably met by " + sayPoints(choice_.points, n_) +
                         ", the fewest tried whose expected error over " + formatReal(params_.duration) + " s stays below it (" +
                         sayError() + "), but not for certain: the estimate is no bound there";
      return true;
    }
    if (findModel(params_.model).maySoften(params_)) chooseMembrane(params_, full_, probe, budget_, choice_);
    if (mayChooseIntegrator(params_)) chooseIntegrator(params_, full_, budget_, probe, choice_);
    choice_.sentence = asked_ + sayPoints(choice_.points, n_) +
                       (choice_.points < n_ ? " simulated, the fewest tried whose" : " simulated, whose") +
                       " expected error over " + formatReal(params_.duration) + " s stays below it (" + sayError() + ")";
    if (choice_.membrane_share < 1.0)
      choice_.sentence += ", with " + formatShort(choice_.membrane_share) +
                          " of the stated membrane stiffness, for which that holds, too (sub-steps are fewer)";
    if (!choice_.why_integrator.empty()) choice_.sentence += "; " + choice_.why_integrator;
    return true;
  }

  // The next number to try; 0: none pays.
  Index findNext() const {
    const Probe& last = trials_.back();
    if (last.is_cut || last.candidate.points >= most_) return 0;
    // A trial that was given up while its error grew has a larger one than was found.
    if (!last.is_whole && std::isfinite(last.candidate.error)) return 0;
    const double affordable = std::pow(budget_.left() / expectWork(last, last.candidate.points), 1.0 / costExponent());
    const double largest = std::min(static_cast<double>(most_), affordable * last.candidate.points);
    double next = predictPoints(trials_, target_);
    if (std::isfinite(next) && next <= largest) {
      next = std::min(largest, std::max(kLeastGrowth * last.candidate.points, predictPoints(trials_, kAim * target_)));
    } else if (!std::isfinite(next)) {
      // Without an estimate nothing tells how many points have one.
      next = static_cast<double>(kBlindGrowth) * last.candidate.points;
    }
    return next <= largest && next > last.candidate.points + 1.0 ? static_cast<Index>(next) : 0;
  }

  // All points, tried if that costs next to nothing.
  void chooseAll() {
    Probe probe = attempt(n_, budget_.left());
    budget_.learnWhole(expectWork(probe, n_));
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
    const bool is_steps_known = is_all && !has_missed && last.candidate.is_bounded && (isStatic() || !last.is_implicit);
    const double steps_error = isStatic() ? 0.0 : last.time_error;  // m
    choice_.take(last.candidate);
    if (points == last.candidate.points) choice_.first_step = last.first_step;
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
    } else if (is_all && last.candidate.points < n_ && !is_steps_known) {
      choice_.sentence = asked_ + "all " + std::to_string(n_) + " points simulated; whether they meet it is not known" +
                         (params_.accuracy.estimate ? " before the run ends" : "") +
                         ", since no trial of all points was made: the expected error of fewer was " + sayError() + " after " +
                         formatShort(last.until) + " s, where " + trial;
    } else if (is_all) {
      choice_.sentence = asked_ + "cannot be met for certain even with every point simulated, which is chosen; " +
                         (is_steps_known ? "the error of the steps was estimated at " + formatShort(steps_error) + " m"
                                         : "the expected error was " + sayError()) +
                         " where " + trial;
    } else if (points == last.candidate.points) {
      choice_.sentence = asked_ + (last.is_cut ? "not known to be met by " : "not met by ") + sayPoints(points, n_) +
                         ", the most whose trial is affordable, which are chosen; its expected error was " + sayError() +
                         " after " + formatShort(last.until) + " s, where the trial ended";
    } else {
      choice_.sentence = asked_ + sayPoints(points, n_) + " simulated, as many as it probably takes by trials of up to " +
                         std::to_string(last.candidate.points) + " points; no trial of as many is affordable";
    }
  }

  std::string sayError() const { return std::isfinite(choice_.error) ? formatShort(choice_.error) + " m" : "not known"; }

  const SceneParams& params_;
  const RestSurface& full_;
  AccuracyChoice& choice_;
  const Index n_;
  const double target_;      // m
  const double most_first_;  // work of the first trial
  const Index most_;         // to try, except all
  WorkBudget budget_;
  std::string asked_;
  std::vector<Probe> trials_;
};

}  // namespace

void chooseByError(const SceneParams& params, const RestSurface& full, AccuracyChoice& choice, double most_first) {
  ChoiceByError(params, full, choice, most_first).choose();
}

}  // namespace deformable_surface::simulation
