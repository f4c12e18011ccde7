// Steps while parts of the surface sleep: what wakes them, the step of the awake part, and what may fall asleep after
// it.
#include "dynamics.h"

#include "deformable_surface/base/step_time.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {

using solve::IntegratorType;

// An equilibrium couples everything.
bool Dynamics::canBeInParts() const {
  return params_.integrator.type != IntegratorType::kStatic && evolution_->maySleepInParts();
}

bool Dynamics::maySleep() const {
  if (params_.sleep.mode == Sleep::kNever) return false;
  if (params_.sleep.mode == Sleep::kAuto && params_.integrator.type == IntegratorType::kExplicitEuler) return false;
  if (!loads_.track.seen().empty()) return false;
  if (params_.output.resample) return false;  // points may be inserted in the next step
  if (untangles()) return false;
  return evolution_->maySleep();
}

void Dynamics::wakeAll() {
  ++revision_;
  if (activity_.isWhole()) return activity_.wakeAll();
  activity_.wakeAll();
  part_.reset();
  march_.resume();
}

void Dynamics::followLoads() {
  Changes changes;
  changes.loads = true;
  follow(changes);
}

// An attraction of all points, a grip that releases at a force, and an inner pressure need all points. So does contact of the
// surface with itself: sleeping parts would not notice others that come to lie on them.
void Dynamics::setParts() {
  const SelfContactLoads* const self = loads_.self_contact.get();
  const bool may_meet = self && (self->mayAct() || !self->contact.proven());
  const bool is_blown = params_.pressure != 0.0 && isClosed(*model_);
  const bool only_wholly = may_meet || is_blown || std::any_of(tools_.begin(), tools_.end(), [](const tool::ToolParams& tool) {
                             return tool.mode == tool::Mode::kAttract || (tool.mode == tool::Mode::kMove && tool.strength > 0.0);
                           });
  activity_.setOnlyWholly(only_wholly);
  if (only_wholly && !activity_.isWhole() && !activity_.isAsleep()) wakeAll();
}

// Elements that depend on the state are those at these positions.
void Dynamics::followPartners(const Points& positions) {
  if (!activity_.isInParts() || !std::isfinite(model_->partition()->maxPartMotion())) return;
  State there;
  there.positions = positions;
  there.traits = now_.points.traits;
  if (model_->innerState()->followPartners(there)) now_.followed = positions;
}

void Dynamics::makePart() {
  part_ = std::make_unique<ActivePart>(*model_, activity_.movingPoints(), params_, loads_, system_.damping());
  part_->march().setMemory(part_march_);
  part_->march().setFineness(fineness_);
  part_->march().setInterrupt(interrupt_);
  part_->watchBreaking(evolution_->breaking());
  if (loads_.self_contact) part_->limitMotion(loads_.self_contact->contact);
}

NamedForces::Update Dynamics::wakeForStep(double now, double dt) {
  NamedForces::Update update = loads_.forces.update(now + kTimeRounding * dt, now_.points, now_.pinned);
  const bool was_whole = activity_.isWhole();
  if (update.changed) {
    activity_.wake(update.points);
    ++revision_;
  }
  // The boxes of changed tools, at their places in the step and at the end of the step before.
  for (const Eigen::AlignedBox3d& box : tool_watch_.look(tools_, static_cast<double>(steps_ + 1) * dt, dt)) activity_.wakeIn(box);
  if (!tool_watch_.changed().empty()) ++revision_;
  grips_.findMovingPins(now, now + dt, moving_);
  if (!moving_.empty()) {
    activity_.wake(moving_);
    ++revision_;
  }
  if (was_whole || !activity_.isWhole()) return update;
  part_.reset();
  march_.resume();
  return update;
}

solve::TimeMarch::Outcome Dynamics::advanceWhole(double now) {
  if (part_) march_.resume();
  part_.reset();
  return march_.step(now, now_.points);
}

// A step of the awake part. If it reaches a wall within the step, the step is repeated with more of the surface.
solve::TimeMarch::Outcome Dynamics::advance(double now) {
  if (!activity_.isWhole() && !maySleep()) wakeAll();
  if (activity_.isWhole()) return advanceWhole(now);
  const double end = now + params_.integrator.time_step;
  for (bool is_new = false;;) {
    if (!part_ || part_->moving() != activity_.movingPoints()) {
      if (part_) part_march_ = part_->march().memory();
      part_march_.energy = {};
      followPartners(now_.points.positions);
      makePart();
      is_new = true;
    }
    part_march_ = part_->march().memory();
    if (!part_->foresee(now_.points, params_.integrator.time_step)) break;
    solve::TimeMarch::Outcome taken = part_->step(now, now_.points, held_, held_turns_);
    if (!taken.ok && interrupt_ && *interrupt_) return taken;
    if (!taken.ok || part_->hasLeftForesight() || part_->hasStretched()) break;
    if (!now_.followed.empty() && part_->hasMoved(now_.followed, model_->partition()->maxPartMotion())) {
      if (is_new) break;  // too far in one step
      part_.reset();
      continue;
    }
    const double at_wall = part_->findHits(end, activity_.acceleration(), activity_.speed(), activity_.spacing(), hits_);
    if (hits_.empty()) {
      activity_.leaveAtWall(at_wall);
      part_->put(now_.points);
      return taken;
    }
    activity_.widen(hits_);
    part_.reset();
    if (activity_.isWhole()) break;
  }
  activity_.wakeAll();
  part_.reset();
  march_.resume();
  return march_.step(now, now_.points);
}

// In the first step of a state: points disturbed by a force or a tool that comes in this step do not sleep. A caller waits for
// the step that wakes them, so that as much as possible is computed now.
void Dynamics::beginAsleep(double now) {
  if (!activity_.isFresh() || !maySleep()) return;
  followPartners(now_.points.positions);
  if (!activity_.beginAsleep(system_, now, now_.points)) return;
  march_.prepare(now, now_.points);
  part_march_ = march_.memory();
  for (const Eigen::AlignedBox3d& box : tool_watch_.changed()) activity_.wakeIn(box);
  grips_.findMovingPins(now, now + params_.integrator.time_step, moving_);
  activity_.wake(moving_);
  ++revision_;
}

// After a successful step.
void Dynamics::considerSleep(const solve::SolveReport& report) {
  if (!maySleep()) return;
  if (params_.integrator.type == IntegratorType::kStatic) {
    // The search ended where it began, and would again. New commands only act from the next step on.
    const bool is_found = report.converged && report.iterations == 0;
    if (is_found && grips_.isEmpty() && tool_watch_.changed().empty()) activity_.sleepWholly(now_.points);
    return;
  }
  activity_.observe(now_.points);
  const bool dissipates = system_.dissipates() || lastMarch().lastType() == IntegratorType::kImplicit;
  if (!activity_.isLookDue() || !dissipates) return;
  if (activity_.isWhole()) {
    part_march_ = march_.memory();
    followPartners(now_.points.positions);
  }
  if (part_) {
    activity_.fallAsleep(part_->system(), time(), part_->state(), &part_->points(), now_.points);
  } else {
    activity_.fallAsleep(system_, time(), now_.points, nullptr, now_.points);
  }
}

}  // namespace deformable_surface::simulation
