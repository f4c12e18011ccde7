#include "deformable_surface/ros/convert/step_schedule.h"

#include <cmath>
#include <utility>

namespace deformable_surface::node {
namespace {

// A clock that runs ahead by more than this at once has jumped; a smaller lag is caught up.
constexpr std::int64_t kForwardJump = 1'000'000'000;
// Small corrections of the computer's clock must not reset a simulation. The clock of a recording has none.
constexpr std::int64_t kCorrection = 1'000'000'000;

}  // namespace

bool ClockWatch::observe(std::int64_t now, std::int64_t steady) {
  bool jumped_back = false;
  if (change_.now != 0) {
    const std::int64_t excess = now - change_.now - (simulated_ ? 0 : steady - last_steady_);
    jumped_back = excess < (simulated_ ? 0 : -kCorrection);
    if (jumped_back) {
      change_.jumped_back = true;
      change_.restart = now;
      change_.skipped = 0;
    } else if (excess > kForwardJump) {
      change_.skipped += excess;
    }
  }
  change_.now = now;
  last_steady_ = steady;
  return jumped_back;
}

ClockChange ClockWatch::take() {
  ClockChange rest;
  rest.now = change_.now;
  return std::exchange(change_, rest);
}

void StepSchedule::start(std::int64_t zero) {
  zero_ = zero;
  skipped_ = 0;
}

void StepSchedule::skipTo(std::int64_t now, std::uint64_t step) {
  if (begin(step) < now) skip(now - begin(step));
}

std::int64_t StepSchedule::stamp(std::uint64_t step) const {
  return zero_ + static_cast<std::int64_t>(std::llround(static_cast<double>(step) * time_step_ * 1e9));
}

}  // namespace deformable_surface::node
