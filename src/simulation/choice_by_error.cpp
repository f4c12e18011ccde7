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
// In clouds whose share of this is less than the fewest points that are tried, nothing but all points is: the run would hardly
// cost less than one of all points, and the estimate is not calibrated there.
constexpr double kMostShare = 0.45;

// From number to number of points tried. That after the first is at least kLeastGrowth times as large.
constexpr double kGrowth = 2.0, kLeastGrowth = 1.5;
// Trials of all numbers take this share of the work of all points: somewhat less than they may, as their work grows unevenly.
constexpr double kShareOfNumbers = 0.9 * kShareOfWhole;

// How the estimate falls with the number of points, estimate ~ points^-rate. The spacing h goes with points^-1/2; errors go with
// h^1 to h^2, mostly.
constexpr double kRate = 0.75, kLeastRate = 0.4, kLargestRate = 1.25;  // as expected, and as far as trials may be believed
constexpr double kAim = 0.7;  // of the target, so that a number of points that is not tried probably meets it

// How the work grows with the number of points, work ~ points^exponent: the sub-steps of explicit steps grow with its root.
// Beside tools contact sets the sub-steps, too: 1.05 to 1.5 in sixteen scenes. Two trials do not tell it: few points are often
// stiffer than many.
constexpr double kCostExponent = 1.5, kCostExponentOfTools = 1.25;

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
        numbers_(listNumbers()),
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
  bool isSmall() const { return kMostShare * n_ < kFewestTried; }
  bool isStatic() const { return params_.integrator.type == IntegratorType::kStatic; }

  // The numbers of points to try, ascending. They are the same for every target.
  std::vector<Index> listNumbers() const {
    const double exponent = costExponent();
    // Trials of most, most / kGrowth, and so on take the share together.
    const double most = n_ * std::pow(kShareOfNumbers * (1.0 - std::pow(kGrowth, -exponent)), 1.0 / exponent);
    std::vector<Index> numbers;
    for (double points = most; points >= kLeastGrowth * kFewestTried; points /= kGrowth)
      numbers.push_back(static_cast<Index>(points));
    numbers.push_back(kFewestTried);
    std::reverse(numbers.begin(), numbers.end());
    return numbers;
  }

  Probe attempt(Index points, double most_work) {
    Candidate tried;
    tried.points = points;
    tried.integrator = params_.integrator.type;
    const double hopeless = target_ * std::pow(std::max(1.0, static_cast<double>(numbers_.back()) / points), kLargestRate);
    ProbeLimits limits{most_work, hopeless};
    // The first trial has a limit of its own, and the first step of an equilibrium does not tell what the others cost.
    if (!trials_.empty() && !isStatic()) limits.budget = &budget_;
    limits.whole_over_own = std::pow(static_cast<double>(n_) / points, costExponent());
    Probe probe = probeError(params_, full_, tried, target_, nullptr, limits);
    budget_.spend(probe.spent);
    choice_.candidates.push_back(probe.candidate);
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
    // A trial that was given up while its error grew has a larger one than was found. Without an estimate nothing tells how many
    // points have one.
    if (last.is_cut || (!last.is_whole && std::isfinite(last.candidate.error))) return 0;
    const auto isAffordable = [&](Index points) { return expectWork(last, points) <= budget_.left(); };
    const auto next = std::upper_bound(numbers_.begin(), numbers_.end(), last.candidate.points);
    if (next == numbers_.end() || !isAffordable(*next)) return 0;
    // An error of more than kGrowth times the target probably needs more than kGrowth times the points. The least of all trials
    // counts: once a number was not left out, none is any more, so that a larger target never takes more points.
    double least = std::numeric_limits<double>::infinity();  // m
    for (const Probe& trial : trials_) least = std::min(least, findLeastError(trial.candidate));
    const bool is_far = least > kGrowth * target_ && next + 1 != numbers_.end() && isAffordable(*(next + 1));
    return is_far ? *(next + 1) : *next;
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
    const auto isSound = [&](const Probe& trial) { return trial.candidate.is_bounded && (isStatic() || !trial.is_implicit); };
    const bool is_steps_known = is_all && !has_missed && isSound(last);
    // The last trial often ends early.
    double steps_error = 0.0;  // m
    bool is_whole = false;
    for (const Probe& trial : trials_) {
      if (!isSound(trial)) continue;
      if (!isStatic()) steps_error = std::max(steps_error, trial.time_error);
      is_whole = is_whole || trial.is_whole;
    }
    choice_.take(last.candidate);
    if (points == last.candidate.points) choice_.first_step = last.first_step;
    choice_.points = points;
    choice_.integrator = params_.integrator.type;
    choice_.work = last.candidate.work * std::pow(static_cast<double>(points) / last.candidate.points, costExponent());
    choice_.is_met = is_steps_known && (isStatic() || is_whole) && steps_error <= target_;
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
  const double target_;               // m
  const double most_first_;           // work of the first trial
  const std::vector<Index> numbers_;  // of points to try, ascending; all points are not among them
  WorkBudget budget_;
  std::string asked_;
  std::vector<Probe> trials_;
};

}  // namespace

void chooseByError(const SceneParams& params, const RestSurface& full, AccuracyChoice& choice, double most_first) {
  ChoiceByError(params, full, choice, most_first).choose();
}

}  // namespace deformable_surface::simulation
