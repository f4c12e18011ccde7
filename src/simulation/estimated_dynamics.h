// A dynamics with its error estimate: the coarser copies follow every command and every step. Apart from both, because the
// simulation and the trials of an accuracy target run the same.
#pragma once

#include "error_estimator.h"

namespace deformable_surface::simulation {

class EstimatedDynamics {
 public:
  /// As Dynamics; without an estimate as yet.
  EstimatedDynamics(const SceneParams& params, RestSurface rest)
      : dynamics_(std::make_unique<Dynamics>(params, std::move(rest))) {}
  /// A fork. to_look: without an estimate, see Dynamics::fork().
  EstimatedDynamics(const EstimatedDynamics& other, bool to_look);

  /// Estimates the error from now on, which is at rest. Throws InputError if the copies cannot be built.
  void estimateError() { estimator_ = std::make_unique<ErrorEstimator>(*dynamics_); }
  Dynamics& dynamics() { return *dynamics_; }
  const Dynamics& dynamics() const { return *dynamics_; }
  ErrorEstimator* estimator() { return estimator_.get(); }  // null: no estimate
  const ErrorEstimator* estimator() const { return estimator_.get(); }
  /// With an estimate, m: what it says of all, and of time stepping; and what falling asleep has cost.
  double error() const { return estimator_->total() + dynamics_->activity().lost(); }
  double timeError() const { return estimator_->time() + dynamics_->activity().lost(); }

  Changes apply(const Command& command);
  void reset();
  void setInterrupt(const std::atomic<bool>* interrupt);
  /// See Dynamics; what that changes is no part of the estimate.
  void softenMembrane(double share);
  void stiffenMembrane();
  /// estimate: null if the state has none, which is then lost.
  void restore(const DynamicsState& saved, const ErrorEstimator::Memory* estimate, bool to_look);

  // As of Dynamics; an interrupt undoes both.
  bool beginStep() { return dynamics_->beginStep(); }
  struct Outcome : Dynamics::Outcome {
    double estimate_seconds = 0.0;  // s of wall time
  };
  Outcome takeStep();
  Outcome passStep();
  Outcome step() { return beginStep() ? takeStep() : passStep(); }

 private:
  void estimate(Outcome& outcome);

  std::unique_ptr<Dynamics> dynamics_;
  std::unique_ptr<ErrorEstimator> estimator_;  // null: no estimate
};

}  // namespace deformable_surface::simulation
