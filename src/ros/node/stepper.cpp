#include "stepper.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/ros/convert/frames.h"
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

// While waiting for a transform.
constexpr milliseconds kPollPeriod(20);
// How often a sleeping surface is updated: its steps then pass at once, and any event wakes the thread at once.
// Less than the lag that is dropped, so that a step that wakes can be caught up.
constexpr milliseconds kRestPeriod(100), kUnsubscribedRestPeriod(200), kLeftAlonePeriod(1000);

}  // namespace

Stepper::Stepper(const simulation::SceneParams& params, Inbox& inbox, CloudWorker& worker, const Publishers& publishers,
                 FrameThread& frames, WrenchPublishers& wrenches, const tf2::BufferCore& transforms, WarningLog& warnings)
    : params_(params),
      inbox_(inbox),
      worker_(worker),
      publishers_(publishers),
      frames_(frames),
      wrenches_(wrenches),
      transforms_(transforms),
      warnings_(warnings),
      is_clock_simulated_(ros::Time::isSimTime()),
      delay_(std::llround(params.input.delay * 1e9)),
      schedule_(params.integrator.time_step),
      commands_(params.force, params.input, transforms, warnings) {}

bool Stepper::turn(Inbox::SteadyTime until) {
  Inbox::Content content = inbox_.take(nextDeadline(until));
  if (content.closed) return false;
  last_turn_ = steady_clock::now();
  handleClock(content.clock);
  reportBuilding();
  for (Command& command : content.commands)
    if (!command.is_stamped) command.stamp = stampOfArrival(command.stamp, timeStep());
  commands_.append(std::move(content.commands));
  if (!content.tools_refused.empty()) commands_.toolStatuses().reportRefused(Tool(), content.tools_refused);
  if (content.cloud) clouds_.put(std::move(*content.cloud));
  if (now_ != 0) handleClouds();
  handleChoice();
  if (simulation_ && !is_gravity_known_) updateGravity();
  // Services see the time that passed while the surface slept.
  bool has_stepped = false;
  while (isDue() && simulation_->isAsleep() && hasFrames() && takeStep()) has_stepped = true;
  // The clock was read before the calls: their time shows as lag in the next turn.
  const double call_seconds = call_seconds_;
  const Timer calls;
  inbox_.doJobs();
  call_seconds_ = calls.seconds();
  if (content.frame_wanted && simulation_) show();
  letGoOfLag(call_seconds);
  if (isDue() && hasFrames() && takeStep()) has_stepped = true;
  publishToolStatuses();
  if (has_stepped && std::exchange(is_frame_due_, false) && isWanted()) frames_.show(makeMoment());
  return true;
}

Inbox::SteadyTime Stepper::nextDeadline(Inbox::SteadyTime until) const {
  const auto now = steady_clock::now();
  if (!clouds_.isEmpty() || (simulation_ && !is_gravity_known_)) until = std::min<Inbox::SteadyTime>(until, now + kPollPeriod);
  if (!simulation_ || isPaused() || hold_.isActive() || !is_gravity_known_) return until;
  if (isLockstep()) {
    if (!isDue()) return until;  // a command wakes the inbox
    return missing_since_ ? std::min<Inbox::SteadyTime>(until, now + kPollPeriod) : Inbox::SteadyTime(now);
  }
  if (canRest()) {
    const milliseconds unsubscribed = simulation_->isLeftAlone() ? kLeftAlonePeriod : kUnsubscribedRestPeriod;
    const milliseconds period = publishers_.hasStatisticsSubscribers() ? kRestPeriod : unsubscribed;
    return std::min<Inbox::SteadyTime>(until, std::max<Inbox::SteadyTime>(now, last_turn_ + period));
  }
  if (isDue()) return now;
  // A simulated clock wakes the inbox itself.
  if (is_clock_simulated_) return until;
  const std::int64_t due =
      schedule_.begin(simulation_->stepCount() + 1) - delayed(static_cast<std::int64_t>(ros::Time::now().toNSec()));
  return due > kMaxAhead ? until
                         : std::min<Inbox::SteadyTime>(until, now + std::chrono::nanoseconds(std::max<std::int64_t>(due, 0)));
}

// Only time passes in the next steps, and no subscriber needs each of them.
bool Stepper::canRest() const {
  return simulation_->isAsleep() && !commands_.isMoving() && ready_.empty() && !wrenches_.hasSubscribers() &&
         (params_.gravity_frame.empty() || withoutSlash(params_.gravity_frame) == frame_);
}

// ---- Steps ----

std::string Stepper::obstacle() {
  if (!simulation_)
    return std::string("there is no surface yet; ") + (now_ == 0      ? "the clock has not started: nothing came on /clock"
                                                       : isBuilding() ? "one is being built"
                                                                      : "publish a cloud on ~cloud_in first");
  if (!is_gravity_known_ && !updateGravity()) return "the transform of gravity_frame is not known yet";
  return "";
}

bool Stepper::isDue() const {
  if (!simulation_ || isPaused() || hold_.isActive() || !is_gravity_known_) return false;
  if (isLockstep()) return hasAllCommands();
  return now_ != 0 && now_ >= schedule_.begin(simulation_->stepCount() + 1);
}

bool Stepper::hasAllCommands() const { return commands_.areCompleteAt(schedule_.begin(simulation_->stepCount())); }

// Waits for a missing frame as long as for a command.
bool Stepper::hasFrames() {
  if (!isLockstep()) return true;
  const std::uint64_t step = simulation_->stepCount();
  const std::string missing = commands_.missingFrame(schedule_.begin(step), schedule_.begin(step + 1), frame_);
  if (missing.empty()) {
    missing_since_.reset();
    return true;
  }
  if (!missing_since_) missing_since_ = steady_clock::now();
  if (steady_clock::now() - *missing_since_ > kTransformPatience) return true;
  warnings_.report(Warning::kWaiting, "step " + std::to_string(step) + " waits for a transform of frame " + quote(missing));
  return false;
}

void Stepper::skipTo(std::int64_t now, std::uint64_t step) {
  if (!isLockstep()) schedule_.skipTo(now, step);
}

void Stepper::resumeAt(std::int64_t now, std::uint64_t step) {
  if (!isLockstep()) schedule_.resumeAt(now, step);
}

bool Stepper::waitsUntilLater(std::int64_t now) const { return schedule_.begin(simulation_->stepCount()) > now + timeStep(); }

void Stepper::setPaused(bool paused) {
  if (isPaused() && !paused && simulation_) skipTo(now_, simulation_->stepCount());
  if (!paused) is_failed_ = false;
  is_paused_ = paused;
  was_paused_ = was_paused_ || paused;
}

// At once, even if the clock is behind the cloud's stamp.
void Stepper::reset() {
  commands_.clear();
  restart(now_);
  if (now_ != 0) resumeAt(now_, 0);
}

void Stepper::letGo(Hold::Id id) {
  if (hold_.end(id)) skipTo(now_, simulation_->stepCount());
}

void Stepper::replaceHeld(Hold::Id id, std::unique_ptr<simulation::Simulation> simulation) {
  if (!hold_.end(id)) throw InputError("the surface was reset, restored or replaced meanwhile; nothing was changed");
  skipTo(now_, simulation_->stepCount());
  simulation_ = std::move(simulation);
  simulation_->setInterrupt(inbox_.endingStep());
  is_as_built_ = false;
  showResult();
}

void Stepper::requireFree() const {
  if (hold_.isActive()) throw InputError("a surface is being grown (~grow_surface); accepted: once that is done");
}

void Stepper::keepSnapshot(const std::string& name) {
  snapshots_.put(name, {simulation_->snapshot(), commands_.memory(), simulation_->stateHash()});
}

void Stepper::restoreSnapshot(const std::string& name) {
  const SnapshotShelf::Entry& entry = snapshots_.find(name);
  hold_.cancel();
  tracking_.forgetLast();
  simulation_->restore(entry.snapshot);
  commands_.restore(entry.commands);
  simulation::setPhysics(simulation::findPhysics(simulation_->params()), params_);
  ++params_revision_;
  if (on_params_) on_params_();
  is_failed_ = is_frame_due_ = false;
  last_frame_ = countFrames();
  resumeAt(now_, simulation_->stepCount());
}

void Stepper::setParams(const simulation::SceneParams& params) {
  requireFree();
  if (simulation_) {
    simulation_->setParams(params);
  }
  params_ = params;
  ++params_revision_;
  if (!simulation_) return;
  last_frame_ = countFrames();
  updateGravity();
  Moment moment = makeMoment();
  moment.params = simulation_->params();
  moment.all = moment.is_kept = true;
  frames_.show(std::move(moment));
  publishWrenches();
}

double Stepper::secondsInStep() const {
  const steady_clock::rep began = step_began_;
  if (began == 0) return 0.0;
  return std::chrono::duration<double>(steady_clock::now().time_since_epoch() - steady_clock::duration(began)).count();
}

std::uint32_t Stepper::takeSteps(std::uint32_t count) {
  skipTo(now_, simulation_->stepCount());
  std::uint32_t taken = 0;
  while (taken < count && !*inbox_.endingStep() && takeStep()) ++taken;
  is_frame_due_ = false;
  // They may have run ahead of the clock; later steps do not wait for it.
  if (now_ != 0) resumeAt(now_, simulation_->stepCount());
  commands_.forgetSteps();
  return taken;
}

bool Stepper::takeStep() {
  const Timer timer;
  const std::uint64_t step = simulation_->stepCount();
  commands_.apply(schedule_.begin(step), schedule_.begin(step + 1), *simulation_, frame_);
  updateGravity();
  time_input_ = timer.seconds();

  const simulation::StepOutcome outcome = [this] {
    struct Mark {
      std::atomic<steady_clock::rep>& began;
      ~Mark() { began = 0; }
    };
    const Mark mark{step_began_};  // which an exception must not leave
    step_began_ = steady_clock::now().time_since_epoch().count();
    return simulation_->step();
  }();
  step_seconds_ = timer.seconds();
  if (!outcome.notice.empty()) warnings_.report(Warning::kNotice, outcome.notice);
  if (!outcome.ok && *inbox_.endingStep()) return false;
  if (!outcome.ok) {
    is_failed_ = true;
    warnings_.report(Warning::kStep,
                     outcome.problem + "; the simulation is paused, ~pause false tries again, ~reset starts over");
    showStop();
    return false;
  }
  ++counts_.steps_taken;
  publishWrenches();
  const std::int64_t frame = countFrames();
  is_frame_due_ = is_frame_due_ || frame > last_frame_;
  last_frame_ = std::max(frame, last_frame_);
  return true;
}

// Rounding must not delay a frame by a step.
std::int64_t Stepper::countFrames() const {
  return static_cast<std::int64_t>(std::floor(simulation_->time() * params_.output.publish_rate + 1e-6));
}

// The transform at the beginning of the step. The first one may be younger: without it no step is taken and no time passes.
Eigen::Isometry3d Stepper::findGravityTransform() const {
  const auto find = [&](const ros::Time& stamp) {
    return findTransformUntil("gravity_frame", params_.gravity_frame, frame_, stamp, transforms_).transform;
  };
  try {
    return find(ros::Time().fromNSec(static_cast<std::uint64_t>(schedule_.begin(simulation_->stepCount()))));
  } catch (const FrameError&) {
    if (is_gravity_known_) throw;
    return find(ros::Time());
  }
}

bool Stepper::updateGravity() {
  if (params_.gravity_frame.empty() || withoutSlash(params_.gravity_frame) == frame_) return is_gravity_known_ = true;
  try {
    gravity_rotation_ = findGravityTransform().linear();
  } catch (const InputError& error) {
    // Once known, the last one stays.
    if (!is_gravity_known_) {
      warnings_.report(Warning::kWaiting, std::string(error.what()) + "; the surface waits for it");
      return false;
    }
  }
  try {
    simulation_->setGravity(gravity_rotation_ * params_.gravity);
  } catch (const InputError& error) {
    // A component of a turned vector may be larger than those that were given.
    warnings_.report(Warning::kWaiting, "in the frame of the surface " + std::string(error.what()) +
                                            (is_gravity_known_ ? "; the last gravity stays" : "; the surface waits for another"));
    return is_gravity_known_;
  }
  // The time spent waiting is not caught up.
  if (!is_gravity_known_) skipTo(now_, simulation_->stepCount());
  return is_gravity_known_ = true;
}

}  // namespace deformable_surface::node
