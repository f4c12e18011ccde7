// When steps are due: what the ROS clock did, and where the steps of the simulation lie on it. Apart from the thread that takes
// the steps, so that jumps of the clock can be tested without waiting for one. Times are nanoseconds of the ROS clock.
#pragma once

#include <cstdint>

namespace deformable_surface::node {

inline double toSeconds(std::int64_t nanoseconds) { return 1e-9 * static_cast<double>(nanoseconds); }

/// The stamp that makes a command which arrived at a time, without a stamp, count from the step in which it arrived: one that
/// begins then is the next one's.
inline std::int64_t stampOfArrival(std::int64_t arrival, std::int64_t time_step) { return arrival - time_step + 1; }

/// What the ROS clock did since it was last asked.
struct ClockChange {
  std::int64_t now = 0;      // 0 = there is no valid time yet
  std::int64_t skipped = 0;  // sum of the forward jumps, which are not caught up
  bool jumped_back = false;  // what was before the jump counts no more, skipped least of all
  std::int64_t restart = 0;  // the first time after the jump
};

/// Tells jumps from the normal run of a clock.
class ClockWatch {
 public:
  /// simulated: the clock is /clock, whose every message must be observed and which goes at any speed; else it is the computer's,
  /// which is observed at any time and compared with a clock that never jumps.
  explicit ClockWatch(bool simulated) : simulated_(simulated) {}

  /// Returns true if the clock jumped back.
  bool observe(std::int64_t now, std::int64_t steady);
  std::int64_t now() const { return change_.now; }
  bool isSimulated() const { return simulated_; }

  /// What it did since the last call.
  ClockChange take();

 private:
  const bool simulated_;
  ClockChange change_;
  std::int64_t last_steady_ = 0;
};

/// Where the steps lie on the clock: step n begins at zero + n * time_step + what was skipped (pauses, jumps, lag let go).
class StepSchedule {
 public:
  explicit StepSchedule(double time_step) : time_step_(time_step) {}

  /// Step 0 begins at zero.
  void start(std::int64_t zero);
  /// All steps from now on begin later by this.
  void skip(std::int64_t duration) { skipped_ += duration; }
  /// Skips what is needed for the step not to begin before now.
  void skipTo(std::int64_t now, std::uint64_t step);
  /// The step begins now, though it may have been taken before, or lie ahead of the clock.
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
