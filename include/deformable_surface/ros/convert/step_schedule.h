// When steps are due: changes of the ROS clock, and the times of the simulation's steps on it. It is independent of the stepping
// thread, so that jumps of the clock can be tested without waiting. Times are nanoseconds of the ROS clock.
#pragma once

#include <cstdint>

namespace deformable_surface::node {

inline double toSeconds(std::int64_t nanoseconds) { return 1e-9 * static_cast<double>(nanoseconds); }

/// The stamp of a command without one: it then counts from the step in which it arrived. A command that arrives as a step begins
/// belongs to the next step.
inline std::int64_t stampOfArrival(std::int64_t arrival, std::int64_t time_step) { return arrival - time_step + 1; }

/// Changes of the ROS clock since the last call.
struct ClockChange {
  std::int64_t now = 0;      // 0 = there is no valid time yet
  std::int64_t skipped = 0;  // sum of the forward jumps, which are not caught up
  bool jumped_back = false;  // everything before the jump is void, skipped time included
  std::int64_t restart = 0;  // the first time after the jump
};

/// Detects jumps of a clock.
class ClockWatch {
 public:
  /// simulated: the clock is /clock, which may run at any speed; every message of it must be observed. Else it is the computer's
  /// clock: it may be observed at any time, and is compared with a clock that never jumps.
  explicit ClockWatch(bool simulated) : simulated_(simulated) {}

  /// Returns true if the clock jumped back.
  bool observe(std::int64_t now, std::int64_t steady);
  std::int64_t now() const { return change_.now; }
  bool isSimulated() const { return simulated_; }

  /// The changes since the last call.
  ClockChange take();

 private:
  const bool simulated_;
  ClockChange change_;
  std::int64_t last_steady_ = 0;
};

/// Times of the steps: step n begins at zero + n * time_step + skipped time (pauses, jumps, dropped lag).
class StepSchedule {
 public:
  explicit StepSchedule(double time_step) : time_step_(time_step) {}

  /// Step 0 begins at zero.
  void start(std::int64_t zero);
  /// All steps from now on begin later by this.
  void skip(std::int64_t duration) { skipped_ += duration; }
  /// Skips time such that the step does not begin before now.
  void skipTo(std::int64_t now, std::uint64_t step);
  /// The step begins now, even if it was taken before or lies ahead of the clock.
  void resumeAt(std::int64_t now, std::uint64_t step) { skipped_ = now - stamp(step); }

  std::int64_t zero() const { return zero_; }
  std::int64_t begin(std::uint64_t step) const { return stamp(step) + skipped_; }
  /// The cloud's stamp plus the simulation time of the state before the step.
  std::int64_t stamp(std::uint64_t step) const;

  // S.
 private:
  const double time_step_;
  std::int64_t zero_ = 0, skipped_ = 0;
};

}  // namespace deformable_surface::node
