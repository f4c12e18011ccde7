// A trial of a scene: the estimated error over its duration, and its cost. accuracy.cpp and integrator_choice.cpp choose what
// to try.
#pragma once

#include "deformable_surface/simulation/accuracy_choice.h"
#include "deformable_surface/simulation/model_kind.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <limits>
#include <string>
#include <vector>

#include "error_estimator.h"

namespace deformable_surface::simulation {

/// The first number of points tried: its coarser copies still carry a shape, and a step of it costs next to nothing.
constexpr Index kFewestTried = 8 * kCoarsestPoints;

/// The error expected of a trial if its estimate were a bound, m: that of more points may be.
inline double findLeastError(const AccuracyChoice::Candidate& c) { return c.is_bounded ? c.error : c.error / kUnboundedFactor; }

/// "N of n points".
std::string sayPoints(Index points, Index of);

/// The scene itself on fewer points, with the error estimate that will be published.
struct Probe {
  AccuracyChoice::Candidate candidate;
  bool failed = false;        // the expected error exceeds the target, a step failed, or it took more work than granted
  bool is_cut = false;        // it failed only for the work: whether it meets the target is unknown
  bool is_whole = false;      // it ran to its end: the error is that of the whole duration
  double until = 0.0;         // s, how far it ran
  double spent = 0.0;         // work done so far; see Candidate::work
  bool is_implicit = false;   // most steps were the implicit method's
  double time_error = 0.0;    // m, the part of the largest estimate that is due to the steps
  std::vector<Points> looks;  // positions at regular intervals of steps
  std::shared_ptr<const FirstStep> first_step;  // of an equilibrium, if it is sound and cuts nothing
  std::vector<double> apart;                    // m, after each step the largest distance so far from the probe beside it
};

/// All trials together may take this share of the work of running all points once.
constexpr double kShareOfWhole = 1.0 / 3.0;

/// The work of all trials together, see Candidate::work.
class WorkBudget {
 public:
  /// free: trials may take it whatever running all points costs.
  explicit WorkBudget(double free) : free_(free) {}

  void spend(double work) { spent_ += work; }
  /// What running all points once takes, as far as trials of fewer tell.
  void learnWhole(double work) { whole_ = work; }
  double whole() const { return whole_; }
  double spent() const { return spent_; }
  /// For the next trial.
  double left() const;
  /// Whether a trial may go on that has done so much work, as running all points takes this much by its own measure.
  bool allows(double work, double whole) const;

 private:
  const double free_;
  double spent_ = 0.0, whole_ = 0.0;
};

/// When a probe stops early.
struct ProbeLimits {
  double most_work = std::numeric_limits<double>::infinity();  // see Candidate::work
  double hopeless = 0.0;  // m: a probe that has missed the target goes on up to this error, so that its size is known
  const WorkBudget* budget = nullptr;  // beyond most_work it goes on as long as this allows; null: it does not
  double whole_over_own = 0.0;         // work of running all points over that of the probe, for the budget
};

/// Runs a candidate: points, integrator and share of the membrane's stiffness. target: of the accuracy, m.
/// beside: a probe of as many points from which the distance is measured, or null. The work of a probe that stops early is
/// extrapolated to the full duration.
Probe probeError(const SceneParams& params, const RestSurface& full, const AccuracyChoice::Candidate& tried, double target,
                 const Probe* beside = nullptr, const ProbeLimits& limits = {});

}  // namespace deformable_surface::simulation
