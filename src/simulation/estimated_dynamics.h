// A dynamics with its error estimate: the coarser copies follow every command and every step. The
// simulation and the trials of an accuracy target both run it.
#pragma once

#include "error_estimator.h"

namespace deformable_surface::simulation {

struct FirstStep;

class EstimatedDynamics {
 public:
  struct Outcome : Dynamics::Outcome {
    double estimate_seconds = 0.0;  // s of wall time
  };

  /// As Dynamics; at first without an estimate.
  EstimatedDynamics(const SceneParams& params, RestSurface rest)
      : dynamics_(std::make_unique<Dynamics>(params, std::move(rest))) {}
  /// A fork. to_look: without an estimate, see Dynamics::fork().
  EstimatedDynamics(const EstimatedDynamics& other, bool to_look);

  /// Another run of the same scene on as many points has taken this step from its start, with an estimate. The first step takes
  /// it over, bit for bit, as long as no command comes; without an estimate, or with output.error, it is not used. Null: none.
  void expectFirstStep(std::shared_ptr<const FirstStep> taken) { first_step_ = std::move(taken); }
  /// After the first step.
  std::shared_ptr<const FirstStep> keepFirstStep(Outcome taken) const;

  /// At rest: estimates the error from now on. Throws InputError if the copies cannot be built.
  void estimateError() { estimator_ = std::make_unique<ErrorEstimator>(*dynamics_); }
  Dynamics& dynamics() { return *dynamics_; }
  const Dynamics& dynamics() const { return *dynamics_; }
  ErrorEstimator* estimator() { return estimator_.get(); }  // null: no estimate
  const ErrorEstimator* estimator() const { return estimator_.get(); }
  /// With an estimate, m: that of the points in accuracy.regions, and the part of time stepping; both with the error of falling
  /// asleep.
  double errorInRegions() const { return estimator_->inRegions() + dynamics_->activity().lost(); }
  double timeError() const { return estimator_->time() + dynamics_->activity().lost(); }

  Changes apply(const Command& command);
  void reset();
  void setInterrupt(const std::atomic<bool>* interrupt);
  /// See Dynamics; its effect is not part of the estimate.
  void softenMembrane(double share);
  void stiffenMembrane();
  /// estimate: null if the state has none; the estimate is then lost.
  void restore(const DynamicsState& saved, const ErrorEstimator::Memory* estimate, bool to_look);

  // As in Dynamics; an interrupt undoes both.
  bool beginStep() { return dynamics_->beginStep(); }
  Outcome takeStep();
  Outcome passStep();
  Outcome step() { return beginStep() ? takeStep() : passStep(); }

 private:
  void estimate(Outcome& outcome);

  std::unique_ptr<Dynamics> dynamics_;
  std::unique_ptr<ErrorEstimator> estimator_;    // null: no estimate
  std::shared_ptr<const FirstStep> first_step_;  // null: none
};

struct FirstStep {
  DynamicsState dynamics;
  std::shared_ptr<const ErrorEstimator::Memory> estimate;
  EstimatedDynamics::Outcome outcome;
};

}  // namespace deformable_surface::simulation
