// The change from a surface that runs while trials for an accuracy target go on to the one that they chose.
#include "stepper.h"

#include <ros/console.h>

#include <utility>

namespace deformable_surface::node {
namespace {

std::string sayNext(bool has_snapshots, bool has_other_values) {
  return std::string("~reset begins with what trials chose") +
         (has_other_values ? " for the values before the last change or ~restore" : "") +
         (has_snapshots ? ", and drops the snapshots" : "");
}

}  // namespace

// The trials are of the surface from rest, without commands. One that had none, and was not paused (as for ~step), begins anew
// at once: nothing of the user's is lost.
void Stepper::handleChoice() {
  if (!choosing_ || !choosing_->isMade() || hold_.isActive()) return;
  chosen_ = choosing_->take();
  choosing_.reset();
  if (!chosen_->problem.empty()) {
    warnings_.report(
        Warning::kNotice,
        "the trials for accuracy.position_error ended without a choice, and the surface goes on: " + chosen_->problem);
    chosen_.reset();
    return;
  }
  const simulation::AccuracyChoice& choice = chosen_->simulation->accuracyChoice();
  const double target = simulation_->params().accuracy.position_error;
  if (!isFound(choice, target)) {
    trials_ = sayNotFound(choice, target, simulation_->accuracyChoice().points, simulation_->input().size());
    warnings_.report(Warning::kNotice, trials_);
    chosen_.reset();
    return;
  }
  const std::string chosen = choice.sentence;
  if (!is_as_built_ || simulation_->wasCommanded() || was_paused_ || !snapshots_.all().empty()) {
    ROS_INFO_STREAM(warnings_.name() << ": the trials have ended; they chose: " << chosen);
    warnings_.report(Warning::kNotice, "the surface goes on as it is, since it has had commands, a pause or snapshots; " +
                                           sayNext(!snapshots_.all().empty(), params_revision_ != chosen_revision_));
    return;
  }
  ROS_INFO_STREAM(warnings_.name() << ": the surface begins anew with what trials chose: " << chosen);
  restart(now_);
  if (now_ != 0) resumeAt(now_, 0);
  showResult();
}

// At rest, with what trials have chosen meanwhile.
void Stepper::resetSurface() {
  if (!chosen_) return simulation_->reset();
  adopt(std::move(chosen_->simulation), std::move(chosen_->viewer), chosen_revision_);
  chosen_.reset();
  snapshots_.clear();
  is_as_built_ = true;
  for (const std::string& warning : simulation_->buildWarnings()) warnings_.report(Warning::kNotice, warning);
}

std::string Stepper::describeAccuracy() const {
  const std::string& now = simulation_->accuracyChoice().sentence;
  if (choosing_) return now + "; trials go on in the background";
  if (chosen_)
    return now + "; " + sayNext(!snapshots_.all().empty(), params_revision_ != chosen_revision_) + ": " +
           chosen_->simulation->accuracyChoice().sentence;
  return trials_.empty() ? now : now + "; " + trials_;
}

}  // namespace deformable_surface::node
