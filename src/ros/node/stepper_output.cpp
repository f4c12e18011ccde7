// What the simulation thread hands over: moments for display, wrenches, results of commands, and its status.
#include "stepper.h"

#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace deformable_surface::node {

// The ROS time of the state. For a waiting surface, as in a pause, it is the present time; also if it is so late
// that the lag will be dropped.
std::int64_t Stepper::outputStamp() const {
  const std::uint64_t step = simulation_->stepCount();
  if (params_.output.stamp == simulation::OutputStamp::kSimulation) return schedule_.stamp(step);
  const std::int64_t begin = schedule_.begin(step);
  if (isLockstep()) return begin;
  const bool waits = isPaused() || hold_.isActive() || !is_gravity_known_ || begin > now_;
  const bool is_let_go = !is_clock_simulated_ && now_ - begin > kMaxLag;
  return now_ != 0 && (waits || is_let_go) ? now_ : begin;
}

StepSchedule Stepper::scheduleFrom(std::uint64_t step) const {
  StepSchedule schedule = schedule_;
  if (params_.output.stamp == simulation::OutputStamp::kSimulation) {
    schedule.start(schedule.zero());
  } else {
    schedule.resumeAt(outputStamp(), step);
  }
  return schedule;
}

void Stepper::publishWrenches() { wrenches_.publish(*simulation_, outputStamp(), frame_, commands_.silentTools()); }

Moment Stepper::makeMoment() {
  Moment moment;
  moment.sight = simulation_->sight();
  moment.stamp = outputStamp();
  moment.cloud = cloud_;
  moment.time_input = time_input_;
  moment.revision = shown_revision_ = simulation_->revision();
  moment.surface_revision = shown_surface_revision_ = simulation_->surfaceRevision();
  return moment;
}

void Stepper::publishToolStatuses() {
  ToolStatusArray statuses;
  if (!commands_.toolStatuses().takeChanged(statuses)) return;
  statuses.header.stamp.fromNSec(static_cast<std::uint64_t>(simulation_ ? outputStamp() : now_));
  statuses.header.frame_id = frame_;
  wrenches_.publish(statuses);
}

// Making a moment costs a copy of the state.
bool Stepper::isWanted() const {
  return publishers_.isWanted(simulation_->revision() != shown_revision_,
                              simulation_->surfaceRevision() != shown_surface_revision_);
}

void Stepper::show() { show(outputStamp()); }

void Stepper::showResult() { show(outputStamp(), true); }

void Stepper::showStop() {
  if (!simulation_ || new_viewer_) return;
  Moment moment = makeMoment();
  moment.is_kept = moment.is_result = true;
  frames_.show(std::move(moment));
}

void Stepper::show(std::int64_t stamp, bool is_result) {
  Moment moment = makeMoment();
  moment.stamp = stamp;
  if (new_viewer_) {
    moment.viewer = std::move(new_viewer_);
    moment.params = simulation_->params();
    moment.frame = frame_;
  }
  moment.all = moment.is_kept = true;
  moment.is_result = is_result;
  frames_.show(std::move(moment));
  publishWrenches();
}

StepperStatus Stepper::status() const {
  StepperStatus status = counts_;
  status.frames_dropped = frames_.numDropped();
  status.is_failed = is_failed_;
  status.time_step = params_.integrator.time_step;
  status.commands_applied = commands_.numApplied();
  status.commands_late = commands_.numLate();
  status.commands_waiting = commands_.numWaiting();
  status.commands_dropped = commands_.numDropped();
  for (const std::string& id : commands_.silentTools()) status.silent_tools += (status.silent_tools.empty() ? "" : ", ") + id;
  const CloudWorker::Counts came = worker_.counts();
  status.clouds_received = came.received;
  status.clouds_ignored += came.ignored;
  status.clouds_dropped += clouds_.numDropped() + came.replaced;
  if (simulation_) {
    status.simulation_time = simulation_->time();
    status.step = simulation_->stepCount();
    status.accuracy = describeAccuracy();
    status.has_snapped = simulation_->hasSnapped();
    if (tracking_.isLost())
      status.lost = "the tracked cloud shows " + std::to_string(tracking_.last()) + " points of the surface" +
                    (tracking_.most() > 0 ? ", and has shown " + std::to_string(tracking_.most()) : "");
    if (isDue() && !isLockstep()) status.lag = toSeconds(now_ - schedule_.begin(status.step + 1));
  }
  if (is_failed_) {
    status.state = "stopped by a failed step";
  } else if (hold_.isActive()) {
    status.state = "growing a surface";
  } else if (is_paused_) {
    status.state = "paused";
  } else if (now_ == 0) {
    status.state = "waiting for the clock";
  } else if (simulation_ && !is_gravity_known_) {
    status.state = "waiting for the transform of gravity_frame";
  } else if (simulation_ && isLockstep() && !hasAllCommands()) {
    const double begin = std::round(1e3 * toSeconds(schedule_.begin(status.step))) / 1e3;
    status.state = "waiting for commands after " + formatReal(begin) + " s (input.lockstep)";
  } else if (simulation_ && !isLockstep() && waitsUntilLater(now_)) {
    status.state = "waiting for the clock to reach " + formatReal(toSeconds(schedule_.begin(status.step) + delay_)) + " s";
  } else if (simulation_) {
    status.state = "running";
  } else if (isBuilding()) {
    status.state = "building a surface";
  }
  if (isBuilding() && simulation_) status.state += ", while another surface is built";
  if (isBuilding() && !simulation_ && is_paused_) status.state += ", while a surface is built";
  return status;
}

}  // namespace deformable_surface::node
