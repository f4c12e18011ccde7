#include "stepper.h"

#include "frames.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/simulation/run_time_params.h"

#include <ros/console.h>
#include <ros/time.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

namespace deformable_surface::node {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr double kNanoseconds = 1e-9;
// A sensor's transform comes a little after its first cloud; a latched cloud would be lost for ever.
constexpr std::chrono::seconds kTransformPatience(5);
// How often what is waited for, a transform, is looked at.
constexpr milliseconds kPollPeriod(20);
// More lag than this on the computer's clock would only be felt as delay; it is let go instead.
constexpr std::int64_t kMaxLag = 250'000'000;
// A simulated clock may start late or jump; a cloud older than this when it comes is not one that steps should catch up from.
constexpr std::int64_t kOldCloud = 1'000'000'000;
// A stamp further ahead than clocks of different computers ever are is a mistake, which would stop the surface for that long.
constexpr std::int64_t kMaxAhead = 3600'000'000'000;
// Even when steps come too late a picture is shown from time to time, and most of the time is left to steps.
constexpr milliseconds kLateFramePeriod(200);
constexpr double kLateFramesApart = 8.0;  // in the time that one takes

double toSeconds(std::int64_t nanoseconds) { return static_cast<double>(nanoseconds) * kNanoseconds; }

void transformCloud(const Eigen::Isometry3d& transform, cloud::PointCloud& cloud) {
  for (Vec3& p : cloud.positions) p = transform * p;
  for (Vec3& n : cloud.normals) n = transform.linear() * n;
  if (cloud.viewpoint) cloud.viewpoint = transform * *cloud.viewpoint;
}

}  // namespace

Stepper::Stepper(const simulation::SceneParams& params, Inbox& inbox, Publishers& publishers, const tf2::BufferCore& transforms,
                 Complaints& complaints)
    : params_(params),
      inbox_(inbox),
      publishers_(publishers),
      transforms_(transforms),
      complaints_(complaints),
      is_clock_simulated_(ros::Time::isSimTime()),
      schedule_(params.integrator.time_step),
      commands_(params.force, transforms, complaints) {}

bool Stepper::turn(Inbox::SteadyTime until) {
  Inbox::Content content = inbox_.take(nextDeadline(until));
  if (content.closed) return false;
  handleClock(content.clock);
  commands_.append(std::move(content.commands));
  if (content.cloud) {
    waiting_cloud_ =
        std::make_unique<WaitingCloud>(WaitingCloud{std::move(*content.cloud), steady_clock::now() + kTransformPatience});
  }
  // Building takes long: the clock is to be read again before a step.
  const bool was_built = waiting_cloud_ && now_ != 0 && handleCloud();
  if (simulation_ && !is_gravity_known_) updateGravity();
  // The clock was read before them: what they take shows as lag in the next turn.
  const double call_seconds = call_seconds_;
  const Timer calls;
  inbox_.doJobs();
  call_seconds_ = calls.seconds();
  if (content.frame_wanted && simulation_) publish();
  if (was_built) return true;
  letGoOfLag(call_seconds);
  if (isDue() && takeStep()) publishIfDue();
  return true;
}

Inbox::SteadyTime Stepper::nextDeadline(Inbox::SteadyTime until) const {
  const auto now = steady_clock::now();
  if (waiting_cloud_ || (simulation_ && !is_gravity_known_)) until = std::min<Inbox::SteadyTime>(until, now + kPollPeriod);
  if (!simulation_ || isPaused() || !is_gravity_known_) return until;
  if (isDue()) return now;
  // A simulated clock wakes the inbox itself.
  if (is_clock_simulated_) return until;
  const std::int64_t due = schedule_.begin(simulation_->stepCount() + 1) - static_cast<std::int64_t>(ros::Time::now().toNSec());
  return due > kMaxAhead ? until
                         : std::min<Inbox::SteadyTime>(until, now + std::chrono::nanoseconds(std::max<std::int64_t>(due, 0)));
}

// ---- The clock ----

void Stepper::handleClock(const ClockNews& clock) {
  now_ = clock.now;
  if (!clock.jumped_back) {
    schedule_.skip(clock.skipped);
    if (clock.skipped > 0 && simulation_) {
      complaints_.report(Complaint::kClock,
                         "the clock jumped forward by " + formatShort(toSeconds(clock.skipped)) + " s, which is not caught up");
    }
    return;
  }
  ++counts_.jumps_back;
  commands_.clear();
  if (!simulation_) return;
  complaints_.report(Complaint::kClock, "the clock jumped back to " + formatReal(toSeconds(clock.restart)) +
                                            " s; the surface is reset to its rest state");
  restart(clock.restart);
  publish();
}

void Stepper::restart(std::int64_t now) {
  simulation_->reset();
  commands_.forget();
  is_failed_ = false;
  last_frame_ = 0;
  is_frame_due_ = false;
  schedule_.start(schedule_.zero());
  schedule_.skipTo(now, 0);
  is_gravity_known_ = false;
  updateGravity();
}

void Stepper::letGoOfLag(double call_seconds) {
  if (!simulation_ || isPaused() || !is_gravity_known_ || is_clock_simulated_) return;
  const std::int64_t lag = now_ - schedule_.begin(simulation_->stepCount() + 1);
  if (!(lag > kMaxLag)) return;
  schedule_.skip(lag);
  if (2.0 * call_seconds > toSeconds(lag)) {
    counts_.time_in_calls += toSeconds(lag);
    complaints_.report(Complaint::kBehind, "services took " + formatShort(call_seconds) + " s, in which no step was taken; " +
                                               formatShort(toSeconds(lag)) + " s are not caught up");
    return;
  }
  counts_.time_let_go += toSeconds(lag);
  if (simulation_->stepCount() > 0) {
    complaints_.report(Complaint::kBehind, "slower than real time: the last step took " + formatShort(step_seconds_) + " s for " +
                                               formatReal(params_.integrator.time_step) + " s, the last frame " +
                                               formatShort(frame_seconds_) + " s; " + formatShort(toSeconds(lag)) +
                                               " s are not caught up");
  }
}

// ---- The cloud ----

/// Returns true if it took time.
bool Stepper::handleCloud() {
  if (simulation_ && params_.input.policy == simulation::InputPolicy::kIgnore) {
    ++counts_.clouds_ignored;
    waiting_cloud_.reset();
    return false;
  }
  const Index num_points = waiting_cloud_->incoming.decoded.cloud.size();
  try {
    if (!accept(waiting_cloud_->incoming)) return false;
  } catch (const InputError& error) {
    complaints_.report(Complaint::kCloudRefused, std::string("cloud refused: ") + error.what());
  } catch (const std::bad_alloc&) {
    complaints_.report(Complaint::kCloudRefused,
                       "cloud refused: " + std::to_string(num_points) + " points do not fit in memory; accepted: fewer");
  }
  waiting_cloud_.reset();
  return true;
}

/// Returns false to be called again, if a transform may still come.
bool Stepper::accept(IncomingCloud& incoming) {
  DecodedCloud& decoded = incoming.decoded;
  const std::int64_t arrival = incoming.arrival != 0 ? incoming.arrival : now_;
  const std::int64_t stamp = decoded.header.stamp.isZero() ? arrival : static_cast<std::int64_t>(decoded.header.stamp.toNSec());
  if (stamp - arrival > kMaxAhead) {
    throw InputError("header.stamp: found a time " + formatReal(toSeconds(stamp - arrival)) +
                     " s ahead of the clock; accepted: up to " + formatReal(toSeconds(kMaxAhead)) + " s");
  }
  const bool is_tracked = simulation_ && params_.input.policy == simulation::InputPolicy::kTrack;
  const std::string frame =
      is_tracked ? frame_ : withoutSlash(params_.frame_id.empty() ? decoded.header.frame_id : params_.frame_id);
  try {
    const Eigen::Isometry3d transform =
        findTransform("header.frame_id", decoded.header.frame_id, frame, decoded.header.stamp, transforms_);
    if (!transform.isApprox(Eigen::Isometry3d::Identity(), 0.0)) transformCloud(transform, decoded.cloud);
  } catch (const InputError&) {
    if (steady_clock::now() < waiting_cloud_->give_up) return false;
    throw;
  }

  if (is_tracked) {
    simulation_->observe(decoded.cloud);
    ++counts_.clouds_tracked;
    return true;
  }
  auto simulation = std::make_unique<simulation::Simulation>(params_, std::move(decoded.cloud));
  simulation->setInterrupt(inbox_.closing());
  publishers_.begin(*simulation, frame);
  // Commands for the surface before are not for this one; before the first there was none that they could be for.
  if (simulation_) commands_.dropBefore(stamp);
  simulation_ = std::move(simulation);
  frame_ = frame;
  commands_.forget();
  snapshots_.clear();
  is_failed_ = is_frame_due_ = false;
  last_frame_ = 0;
  schedule_.start(stamp);
  if (is_clock_simulated_ && arrival - stamp > kOldCloud) schedule_.skipTo(arrival, 0);
  is_gravity_known_ = false;
  updateGravity();
  ++counts_.clouds_accepted;

  std::string notes;
  for (const std::string& note : simulation_->buildNotes()) appendNotice(notes, note);
  ROS_INFO_STREAM(complaints_.name() << ": surface built: " << notes);
  publish();
  return true;
}

// ---- Steps ----

std::string Stepper::obstacle() {
  if (!simulation_) return "there is no surface yet; publish a cloud on ~cloud_in first";
  if (!is_gravity_known_ && !updateGravity()) return "the transform of gravity_frame is not known yet";
  return "";
}

bool Stepper::isDue() const {
  return simulation_ && !isPaused() && is_gravity_known_ && now_ != 0 && now_ >= schedule_.begin(simulation_->stepCount() + 1);
}

void Stepper::setPaused(bool paused) {
  if (isPaused() && !paused && simulation_) schedule_.skipTo(now_, simulation_->stepCount());
  if (!paused) is_failed_ = false;
  is_paused_ = paused;
}

void Stepper::reset() {
  commands_.clear();
  restart(now_);
}

void Stepper::keepSnapshot(const std::string& name) {
  snapshots_.put(name, {simulation_->snapshot(), commands_.memory(), simulation_->stateHash()});
}

void Stepper::restoreSnapshot(const std::string& name) {
  const SnapshotShelf::Entry& entry = snapshots_.find(name);
  simulation_->restore(entry.snapshot);
  commands_.restore(entry.commands);
  simulation::setPhysics(simulation::findPhysics(simulation_->params()), params_);
  if (on_params_) on_params_();
  is_failed_ = is_frame_due_ = false;
  last_frame_ = countFrames();
  schedule_.resumeAt(now_, simulation_->stepCount());
}

void Stepper::setParams(const simulation::SceneParams& params) {
  if (simulation_) {
    simulation_->setParams(params);
    publishers_.setNormals(*simulation_);
  }
  params_ = params;
  if (!simulation_) return;
  last_frame_ = countFrames();
  updateGravity();
  publish();
}

std::uint32_t Stepper::takeSteps(std::uint32_t count) {
  schedule_.skipTo(now_, simulation_->stepCount());
  std::uint32_t taken = 0;
  while (taken < count && !inbox_.isClosed() && takeStep()) ++taken;
  is_frame_due_ = false;
  return taken;
}

bool Stepper::takeStep() {
  const Timer timer;
  commands_.apply(schedule_.begin(simulation_->stepCount()), *simulation_, frame_);
  updateGravity();
  time_input_ = timer.seconds();

  const simulation::StepOutcome outcome = simulation_->step();
  step_seconds_ = timer.seconds();
  if (!outcome.notice.empty()) complaints_.report(Complaint::kNotice, outcome.notice);
  if (!outcome.ok && inbox_.isClosed()) return false;
  if (!outcome.ok) {
    is_failed_ = true;
    complaints_.report(Complaint::kStep,
                       outcome.problem + "; the simulation is paused, ~pause false tries again, ~reset starts over");
    return false;
  }
  ++counts_.steps_taken;
  const std::int64_t frame = countFrames();
  if (frame > last_frame_) {
    counts_.frames_dropped += is_frame_due_;
    is_frame_due_ = true;
    last_frame_ = frame;
  }
  return true;
}

// Rounding must not delay a frame by a step.
std::int64_t Stepper::countFrames() const {
  return static_cast<std::int64_t>(std::floor(simulation_->time() * params_.output.publish_rate + 1e-6));
}

bool Stepper::updateGravity() {
  if (params_.gravity_frame.empty() || withoutSlash(params_.gravity_frame) == frame_) return is_gravity_known_ = true;
  try {
    const Eigen::Isometry3d transform = findTransform("gravity_frame", params_.gravity_frame, frame_, ros::Time(), transforms_);
    simulation_->setGravity(transform.linear() * params_.gravity);
    // The time spent waiting is not caught up.
    if (!is_gravity_known_) schedule_.skipTo(now_, simulation_->stepCount());
    return is_gravity_known_ = true;
  } catch (const InputError& error) {
    // Once known, the last one stays.
    if (!is_gravity_known_) complaints_.report(Complaint::kWaiting, std::string(error.what()) + "; the surface waits for it");
    return is_gravity_known_;
  }
}

// ---- Output ----

void Stepper::publish() {
  const Timer timer;
  publishers_.publish(*simulation_, schedule_.stamp(simulation_->stepCount()), time_input_);
  frame_seconds_ = timer.seconds();
  last_published_ = steady_clock::now();
}

void Stepper::publishIfDue() {
  if (!is_frame_due_) return;
  // Steps go first when they come late, and the frame waits until they are in time.
  const bool is_late = now_ - schedule_.begin(simulation_->stepCount() + 1) > timeStep();
  const std::chrono::duration<double> apart =
      std::max<std::chrono::duration<double>>(kLateFramePeriod, std::chrono::duration<double>(kLateFramesApart * frame_seconds_));
  if (is_late && steady_clock::now() - last_published_ < apart) return;
  is_frame_due_ = false;
  publish();
}

StepperStatus Stepper::status() const {
  StepperStatus status = counts_;
  status.is_failed = is_failed_;
  status.time_step = params_.integrator.time_step;
  status.commands_applied = commands_.numApplied();
  status.commands_waiting = commands_.numWaiting();
  status.commands_dropped = commands_.numDropped();
  if (simulation_) {
    status.simulation_time = simulation_->time();
    status.step = simulation_->stepCount();
    status.accuracy = simulation_->accuracyChoice().sentence;
    status.lag = std::max(0.0, toSeconds(now_ - schedule_.begin(status.step + 1)));
  }
  if (is_failed_) {
    status.state = "stopped by a failed step";
  } else if (is_paused_) {
    status.state = "paused";
  } else if (now_ == 0) {
    status.state = "waiting for the clock";
  } else if (simulation_ && !is_gravity_known_) {
    status.state = "waiting for the transform of gravity_frame";
  } else if (simulation_) {
    status.state = "running";
  }
  return status;
}

}  // namespace deformable_surface::node
