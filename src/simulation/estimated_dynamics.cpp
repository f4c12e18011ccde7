#include "estimated_dynamics.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cmath>

#include "nested_start.h"

namespace deformable_surface::simulation {
namespace {

// Knives cut; links that are too long tear.
std::string describeCut(const Dynamics& dynamics) {
  const std::vector<tool::ToolParams>& tools = dynamics.tools();
  const bool has_knife =
      std::any_of(tools.begin(), tools.end(), [](const tool::ToolParams& tool) { return tool.mode == tool::Mode::kCut; });
  const bool may_tear = dynamics.params().mass_spring.tear_strain > 0.0;
  return std::string("the surface is ") + (!has_knife ? "torn" : may_tear ? "cut or torn" : "cut");
}

}  // namespace

EstimatedDynamics::EstimatedDynamics(const EstimatedDynamics& other, bool to_look)
    : dynamics_(other.dynamics_->fork(to_look)),
      estimator_(other.estimator_ && !to_look ? std::make_unique<ErrorEstimator>(*other.estimator_) : nullptr),
      first_step_(other.first_step_) {}

Changes EstimatedDynamics::apply(const Command& command) {
  Changes changes = dynamics_->apply(command);
  if (changes.done) first_step_.reset();
  if (!changes.done || !estimator_) return changes;
  const bool was_finite = std::isfinite(estimator_->total());
  estimator_->apply(command);
  if (was_finite && !std::isfinite(estimator_->total()))
    appendNotice(changes.notice,
                 "coarser copies cannot do the same to their own points: there is no error estimate until the next reset");
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
  first_step_.reset();
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

std::shared_ptr<const FirstStep> EstimatedDynamics::keepFirstStep(Outcome taken) const {
  taken.contact_seconds = taken.search_seconds = taken.estimate_seconds = taken.report.time_forces = 0.0;
  return std::make_shared<const FirstStep>(FirstStep{dynamics_->save(), estimator_->memory(), std::move(taken)});
}

EstimatedDynamics::Outcome EstimatedDynamics::takeStep() {
  if (first_step_ && dynamics_->stepCount() == 0 && estimator_ && !dynamics_->params().output.error) {
    dynamics_->restore(first_step_->dynamics);
    estimator_->setMemory(*first_step_->estimate);
    return first_step_->outcome;
  }
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
  const bool has_others = dynamics_->state().size() != static_cast<Index>(dynamics_->rest().points.size());
  const bool has_left = outcome.leaves_copies || has_others, was_finite = std::isfinite(estimator_->total());
  const std::string notice = estimator_->follow(*dynamics_, outcome.report, outcome.has_cut || has_left);
  if (was_finite && (outcome.has_cut || has_left))
    appendNotice(outcome.notice,
                 (outcome.has_cut ? describeCut(*dynamics_) : "particles are torn apart, heated, added or removed") +
                     ", which its coarser copies do not follow: there is no error estimate until the next reset");
  appendNotice(outcome.notice, notice);
  estimator_->learnBalance(dynamics_->params().integrator.type != solve::IntegratorType::kStatic || outcome.report.converged);
  if (outcome.second_distance) appendNotice(outcome.notice, estimator_->learnSecondSearch(*outcome.second_distance));
}

}  // namespace deformable_surface::simulation
