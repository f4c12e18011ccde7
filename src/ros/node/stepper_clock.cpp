// The clock of the simulation thread: jumps, resets, and lag that is dropped.
#include "stepper.h"

#include "deformable_surface/base/value.h"

#include <algorithm>
#include <string>

#include "faster_steps.h"

namespace deformable_surface::node {

std::int64_t Stepper::delayed(std::int64_t clock) const { return clock == 0 ? 0 : std::max<std::int64_t>(clock - delay_, 1); }

void Stepper::handleClock(const ClockChange& clock) {
  now_ = delayed(clock.now);
  if (!clock.jumped_back) {
    // A surface that waited for its time need not catch up what the clock jumped over before.
    const std::int64_t skipped = simulation_ && waitsUntilLater(now_ - clock.skipped)
                                     ? std::max<std::int64_t>(0, now_ - schedule_.begin(simulation_->stepCount() + 1))
                                     : clock.skipped;
    if (isLockstep()) return;
    schedule_.skip(skipped);
    if (skipped > 0 && simulation_) {
      warnings_.report(Warning::kClock,
                       "the clock jumped forward by " + formatShort(toSeconds(skipped)) + " s, which is not caught up");
    }
    return;
  }
  ++counts_.jumps_back;
  commands_.clear();
  if (!simulation_) return;
  restart(delayed(clock.restart));
  warnings_.report(
      Warning::kClock,
      "the clock jumped back to " + formatReal(toSeconds(clock.restart)) + " s; the surface is reset to its rest state" +
          (waitsUntilLater(now_) ? ", where it stays until " + formatReal(toSeconds(schedule_.begin(0) + delay_)) +
                                       " s, the stamp of its cloud, for a recording that begins anew; ~reset begins at once"
                                 : ""));
  showResult();
}

// Before the surface begins anew, or another one comes.
void Stepper::tellWhatLasted() {
  const std::string lasted = simulation_->lastingNotices();
  if (!lasted.empty()) warnings_.report(Warning::kNotice, "until the end of this run: " + lasted);
}

void Stepper::restart(std::int64_t now) {
  tellWhatLasted();
  resetSurface();
  beginAnew(schedule_.zero());
  skipTo(now, 0);
  updateGravity();
}

// The surface is at rest, and everything before is forgotten; time 0 is at zero of the clock.
void Stepper::beginAnew(std::int64_t zero) {
  hold_.cancel();
  is_failed_ = is_frame_due_ = is_gravity_known_ = false;
  was_paused_ = is_paused_;
  last_frame_ = 0;
  ready_.clear();
  tracking_ = {};
  commands_.forget();
  schedule_.start(zero);
}

void Stepper::letGoOfLag(double call_seconds) {
  if (!simulation_ || isPaused() || hold_.isActive() || !is_gravity_known_ || is_clock_simulated_ || isLockstep()) return;
  const std::int64_t lag = now_ - schedule_.begin(simulation_->stepCount() + 1);
  if (!(lag > kMaxLag)) return;
  schedule_.skip(lag);
  if (simulation_->stepCount() == 0) {
    counts_.time_in_builds += toSeconds(lag);  // which the message about the surface has reported
    return;
  }
  if (2.0 * call_seconds > toSeconds(lag)) {
    counts_.time_in_calls += toSeconds(lag);
    warnings_.report(Warning::kBehind, "services took " + formatShort(call_seconds) + " s, in which no step was taken; " +
                                           formatShort(toSeconds(lag)) + " s are not caught up");
    return;
  }
  counts_.time_let_go += toSeconds(lag);
  const bool is_slow = step_seconds_ > params_.integrator.time_step;
  const std::string why = is_slow ? "slower than real time" : "the process did not get to run for a while";
  const std::string faster = is_slow ? "; faster, beginning with what changes the least: " +
                                           nameFaster(params_, simulation_->statistics(), touchesCloudPoints(*simulation_))
                                     : "";
  warnings_.report(Warning::kBehind, why + ": the last step took " + formatShort(step_seconds_) + " s for " +
                                         formatReal(params_.integrator.time_step) + " s; " + formatShort(toSeconds(lag)) +
                                         " s are not caught up" + faster);
}

}  // namespace deformable_surface::node
