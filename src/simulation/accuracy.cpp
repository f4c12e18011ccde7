#include "accuracy.h"

#include "deformable_surface/base/value.h"
#include "deformable_surface/simulation/simulation.h"
#include "error_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace deformable_surface::simulation {
namespace {

using Candidate = AccuracyChoice::Candidate;
using solve::IntegratorType;

// The first number tried: its coarser copies still carry a shape, and a step of it costs next to nothing.
constexpr Index kFewest = 8 * kCoarsestPoints;
// The membranes that are tried: each has this share of the stiffness of the one before, so that its steps take half as many sub-steps.
constexpr double kSofter = 0.25;
constexpr double kWorthwhile = 0.9;  // of the work: what a softer membrane must save, else bending or loads ask for the sub-steps
constexpr double kMostKept = 2e6;    // points whose positions are kept of a probe: some fifty megabytes
// Points times sub-steps of a probe, about ten seconds of one core: a finer one is not begun if it would take more.
constexpr double kMostWork = 1e8;
// What a Newton iteration costs over a force pass, roughly.
constexpr double kNewtonCost = 30.0;
// Cost of an explicit step by the number of points: the sub-steps grow with its root.
constexpr double kCostExponent = 1.5;
constexpr int kTimedSteps = 5;  // of which the fastest counts: other work on the machine only ever makes them slower
constexpr int kSettled = 25;    // steps of a probe that fits: the last ones see a surface in motion, whose sub-steps are finer

std::string sayPoints(Index points, Index of) { return std::to_string(points) + " of " + std::to_string(of) + " points"; }

// A probe: the scene itself on fewer points, with the error estimate that will be published.
struct Probe {
  Candidate candidate;
  double work = 0.0;   // points times sub-steps of the whole duration
  bool failed = false;
  std::vector<Points> looks;      // positions at every so many steps
  std::vector<double> softening;  // m, after each step the largest distance so far from those of the probe beside it
};

// beside: a probe of as many points with all of the stated stiffness, for one with a share of it.
Probe probeError(const SceneParams& params, const RestSurface& full, Index points, double membrane_share, const Probe* beside) {
  Probe probe;
  probe.candidate.points = points;
  probe.candidate.membrane_share = membrane_share;
  SceneParams quiet = params;
  quiet.accuracy = AccuracyParams{};
  Simulation simulation(quiet, buildCoarser(quiet, full, points));
  simulation.estimateError(full);
  if (beside) simulation.softenMembrane(membrane_share);
  const Index steps = std::max(Index{1}, static_cast<Index>(std::lround(params.duration / params.integrator.time_step)));
  const Index between = static_cast<Index>(static_cast<double>(points) * steps / kMostKept) + 1;
  double apart = 0.0;
  for (Index k = 1; k <= steps; ++k) {
    const StepOutcome outcome = simulation.step();
    const Statistics now = simulation.statistics();
    const Points& positions = simulation.state().positions;
    if (k % between == 0 && beside) {
      const Points& stated = beside->looks[k / between - 1];
      for (std::size_t i = 0; i < stated.size(); ++i) apart = std::max(apart, (positions[i] - stated[i]).norm());
    } else if (k % between == 0) {
      probe.looks.push_back(positions);
    }
    if (beside) probe.softening.push_back(apart);
    const double error = outcome.ok ? now.error_estimate + apart : std::numeric_limits<double>::infinity();
    probe.candidate.error = std::max(probe.candidate.error, error);
    probe.work += static_cast<double>(points) * (now.solver_iterations > 0 ? kNewtonCost * now.solver_iterations : now.substeps);
    if (probe.candidate.error <= params.accuracy.position_error) continue;
    // It has failed; what all of it would have cost is still of interest.
    probe.work *= static_cast<double>(steps) / k;
    probe.failed = true;
    return probe;
  }
  return probe;
}

// What meets tools, and what tears, must be as stiff as stated; an equilibrium costs the same for any stiffness.
bool maySoften(const SceneParams& params) {
  return params.tools.empty() && params.mass_spring.tear_strain == 0.0 && params.integrator.type != IntegratorType::kStatic &&
         params.mass_spring.stiffness == model::Stiffness::kMaterial;
}

// The softest membrane whose estimate stays below the wish, and how far the probe with it is from the one with the stated stiffness.
void chooseMembrane(const SceneParams& params, const RestSurface& full, const Probe& stated, AccuracyChoice& choice) {
  double work = stated.work;
  const auto isBetter = [&](double share) {
    Probe probe = probeError(params, full, choice.points, share, &stated);
    choice.candidates.push_back(probe.candidate);
    if (probe.failed || !(probe.work < kWorthwhile * work)) return false;
    choice.membrane_share = share;
    choice.softening = std::move(probe.softening);
    choice.error = probe.candidate.error;
    work = probe.work;
    return true;
  };
  double share = kSofter;
  while (isBetter(share)) share *= kSofter;
  isBetter(share / std::sqrt(kSofter));  // half way back
}

// The fewest points whose estimate stays below the wish.
Index chooseByError(const SceneParams& params, const RestSurface& full, AccuracyChoice& choice) {
  const Index n = static_cast<Index>(full.dense.positions.size());
  const double wish = params.accuracy.position_error;
  const std::string asked = "accuracy.position_error " + formatReal(wish) + " m: ";
  for (Index points = std::min(kFewest, n);; points = std::min(2 * points, n)) {
    const Probe probe = probeError(params, full, points, 1.0, nullptr);
    choice.candidates.push_back(probe.candidate);
    choice.points = points;
    choice.is_met = !probe.failed;
    choice.error = probe.candidate.error;
    if (choice.is_met && maySoften(params)) chooseMembrane(params, full, probe, choice);
    const std::string estimate = formatReal(choice.error) + " m";
    if (choice.is_met) {
      choice.sentence = asked + sayPoints(points, n) + " simulated, the fewest tried whose estimated error over " +
                        formatReal(params.duration) + " s stays below it (" + estimate + ")";
      if (choice.membrane_share < 1.0)
        choice.sentence += ", with " + formatReal(choice.membrane_share) +
                           " of the stated membrane stiffness, the least tried for which that holds (sub-steps are fewer)";
      break;
    }
    const std::string reached = "; its estimated error has reached " + estimate;
    if (points == n) {
      choice.sentence = asked + "cannot be met even with every point simulated, which is chosen" + reached;
      break;
    }
    const double next_work = probe.work * std::pow(static_cast<double>(std::min(2 * points, n)) / points, kCostExponent);
    if (next_work > kMostWork) {
      choice.sentence = asked + "not met by " + sayPoints(points, n) + ", the most whose trial is affordable, which are chosen" +
                        reached;
      break;
    }
  }
  return choice.points;
}

// What the step of a probe costs, s.
double timeProbe(const SceneParams& params, const RestSurface& full, Index points) {
  SceneParams quiet = params;
  quiet.accuracy = AccuracyParams{};
  quiet.activity.sleep = Sleep::kNever;  // what is timed is a surface in motion
  Simulation simulation(quiet, buildCoarser(quiet, full, points));
  if (params.accuracy.estimate) simulation.estimateError(full);
  const auto step = [&] {
    return simulation.step().ok ? simulation.statistics().time_total : std::numeric_limits<double>::infinity();
  };
  return timeSteps(step, params.accuracy.step_budget);
}

}  // namespace

double timeSteps(const std::function<double()>& step, double budget) {
  std::array<double, kTimedSteps> last;
  last.fill(std::numeric_limits<double>::infinity());
  double spent = 0.0;
  for (int k = 0; k <= kTimedSteps || (k < kSettled && spent < kSettled * budget); ++k) {
    const double seconds = step();
    if (!std::isfinite(seconds)) return seconds;
    if (k == 0) continue;  // it also makes what later ones keep
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
  for (Index points = std::min(kFewest, n);; points = std::min(2 * points, n)) {
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

RestSurface buildChosen(const SceneParams& params, const cloud::PointCloud& input, AccuracyChoice& choice) {
  const AccuracyParams& wish = params.accuracy;
  choice = AccuracyChoice{};
  choice.is_asked = wish.position_error > 0.0 || wish.step_budget > 0.0;
  const bool needs_coarser = choice.is_asked || wish.estimate || params.integrator.type == IntegratorType::kStatic;
  const Index coarsest = needs_coarser ? kCoarsestPoints : kMaxIndex;
  if (!choice.is_asked) return buildRestSurface(params, input, coarsest);
  RestSurface rest = buildRestSurface(params, input, coarsest, [&](const RestSurface& full) {
    if (wish.position_error > 0.0) return chooseByError(params, full, choice);
    const auto time_step = [&](Index points) { return timeProbe(params, full, points); };
    return chooseByTime(static_cast<Index>(full.dense.positions.size()), wish.step_budget, time_step, choice);
  });
  rest.notes.push_back(choice.sentence);
  return rest;
}

}  // namespace deformable_surface::simulation
