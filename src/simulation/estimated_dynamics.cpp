#include "estimated_dynamics.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/timer.h"

#include <cmath>

#include "nested_start.h"

namespace deformable_surface::simulation {

EstimatedDynamics::EstimatedDynamics(const EstimatedDynamics& other, bool to_look)
    : dynamics_(other.dynamics_->fork(to_look)),
      estimator_(other.estimator_ && !to_look ? std::make_unique<ErrorEstimator>(*other.estimator_) : nullptr) {}

Changes EstimatedDynamics::apply(const Command& command) {
  Changes changes = dynamics_->apply(command);
  if (changes.done && estimator_) estimator_->apply(command);
  return changes;
}

void EstimatedDynamics::reset() {
  dynamics_->reset();
  if (estimator_) estimator_->reset();
}

void EstimatedDynamics::setInterrupt(const std::atomic<bool>* interrupt) {
  dynamics_->setInterrupt(interrupt);
  if (estimator_) estimator_->setInterrupt(interrupt);
}

void EstimatedDynamics::softenMembrane(double share) {
  dynamics_->softenMembrane(share);
  if (estimator_) estimator_->softenMembrane(share);
}

void EstimatedDynamics::stiffenMembrane() {
  dynamics_->stiffenMembrane();
  if (estimator_) estimator_->stiffenMembrane();
}

void EstimatedDynamics::restore(const DynamicsState& saved, const ErrorEstimator::Memory* estimate, bool to_look) {
  dynamics_->restore(saved, to_look);
  if (estimator_ && estimate) estimator_->setMemory(*estimate);
  if (estimator_ && !estimate) estimator_->lose();
}

// The copies sleep, or catch up in the next step.
EstimatedDynamics::Outcome EstimatedDynamics::passStep() {
  Outcome outcome{dynamics_->passStep()};
  if (estimator_) estimator_->pass();
  return outcome;
}

EstimatedDynamics::Outcome EstimatedDynamics::takeStep() {
  Dynamics::Request request;
  request.find_start = [this](const SceneParams& now) { return findNestedStart(now, dynamics_->rest(), dynamics_->interrupt()); };
  if (estimator_ && estimator_->wantsSecondSearch()) request.second_search = estimator_->searchDisturbance();
  Outcome outcome{dynamics_->takeStep(request)};
  if (!estimator_ || !outcome.ok) return outcome;
  if (outcome.has_slept) {
    estimator_->pass();
    return outcome;
  }
  const Timer timer;
  try {
    estimate(outcome);
  } catch (const Interrupted& interrupted) {
    dynamics_->undoStep();
    outcome.ok = false;
    outcome.failure = interrupted.what();
  } catch (...) {
    dynamics_->undoStep();
    throw;
  }
  outcome.estimate_seconds = timer.seconds() + outcome.search_seconds;
  return outcome;
}

// The copies take the same step. If it is interrupted, none of them has taken it.
void EstimatedDynamics::estimate(Outcome& outcome) {
  if (outcome.has_new_arrival) estimator_->adoptArrivals(dynamics_->loads().contact);
  const bool ends = outcome.has_cut && std::isfinite(estimator_->total());
  const std::string notice = estimator_->follow(*dynamics_, outcome.has_cut);
  if (ends)
    appendNotice(outcome.notice,
                 "the surface is cut, which its coarser copies do not follow: there is no error estimate until the next reset");
  appendNotice(outcome.notice, notice);
  estimator_->learnBalance(dynamics_->params().integrator.type != solve::IntegratorType::kStatic || outcome.report.converged);
  if (outcome.second_distance) appendNotice(outcome.notice, estimator_->learnSecondSearch(*outcome.second_distance));
}

}  // namespace deformable_surface::simulation
