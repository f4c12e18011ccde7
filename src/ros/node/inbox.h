// The queue of everything that comes from outside for the simulation thread: clouds, commands, service calls, the clock.
// Callbacks only put events here: no message waits for a step, and the simulation needs no locks.
#pragma once

#include "deformable_surface/PointForce.h"
#include "deformable_surface/Tool.h"
#include "deformable_surface/ros/convert/cloud_decoder.h"
#include "deformable_surface/ros/convert/frames.h"
#include "deformable_surface/ros/convert/step_schedule.h"

#include <geometry_msgs/WrenchStamped.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

namespace deformable_surface::node {

/// A cloud and the time (ns of the ROS clock) at which it came; 0 if there was no valid time yet.
struct IncomingCloud {
  DecodedCloud decoded;
  std::int64_t arrival = 0;
};

/// A command and its stamp (ns), or the time of its arrival if it has none. It counts from the first step that begins at its
/// stamp or later, or from the one in which it arrives.
struct Command {
  std::int64_t stamp = 0;
  // One of the three:
  PointForceConstPtr force;
  geometry_msgs::WrenchStampedConstPtr wrench;
  ToolConstPtr tool;
  bool is_stamped = true;
  std::optional<SeenTransform> seen;  // without a stamp: of its frame, when it arrived

  const std_msgs::Header& header() const { return force ? force->header : wrench ? wrench->header : tool->header; }
};

class Inbox {
 public:
  using SteadyTime = std::chrono::steady_clock::time_point;

  /// Work for the simulation thread; a service call waits for it.
  struct Job {
    enum class State { kWaiting, kRunning, kDone, kRefused };
    const std::function<void()>* work;
    bool ends_step;
    State state = State::kWaiting;
    std::exception_ptr problem{};  // thrown by the work
  };

  struct Content {
    std::optional<IncomingCloud> cloud;
    std::vector<Command> commands;  // in the order of arrival; none from before a jump back of the clock
    std::string tools_refused;      // why the last message of tools could not be read; empty: each could
    bool frame_wanted = false;
    bool closed = false;
    ClockChange clock;
  };

  /// Longer than building the largest usual surface takes. After that the caller is asked to try again.
  static constexpr std::chrono::seconds kPatience{30};

  /// patience: how long perform() waits for its work to begin.
  Inbox(bool use_simulated_clock, const tf2::BufferCore& transforms, std::chrono::milliseconds patience = kPatience)
      : clock_(use_simulated_clock), transforms_(transforms), patience_(patience) {}

  // For callbacks. Only perform() waits.
  /// Replaces a cloud that was not fetched yet. arrival: as in IncomingCloud.
  void put(DecodedCloud&& cloud, std::int64_t arrival);
  /// If there are too many, the oldest is dropped.
  void put(const PointForceConstPtr& force);
  void put(const geometry_msgs::WrenchStampedConstPtr& wrench);
  void put(const ToolConstPtr& tool);
  /// Why a message of tools was refused.
  void putRefusedTools(const std::string& reason);
  /// ns of the ROS clock; 0 if there is no valid time yet.
  std::int64_t now();
  /// A message of /clock.
  void observeClock(std::int64_t now);
  /// Asks for a frame at once, for a new subscriber.
  void wantFrame();
  /// Wakes the simulation thread, for the diagnostics.
  void wake();
  /// Lets the simulation thread do the work, and waits for it. Throws what the work throws, and InputError if it was not done.
  /// ends_step: a running step is void and is ended.
  void perform(const std::function<void()>& work, bool ends_step = false);
  /// Ends the simulation thread; waiting calls are refused.
  void close();

  // For the simulation thread.
  /// Waits until something comes or the time is reached, and takes everything but the jobs.
  Content take(SteadyTime until);
  /// Sets the frame of the surface that commands are for.
  void setSurfaceFrame(const std::string& frame);
  /// Does the waiting jobs.
  void doJobs();
  bool isClosed() const { return closed_; }
  /// The closed state, for code to check while it works.
  const std::atomic<bool>* closing() const { return &closed_; }
  /// Whether a running step must end; steps check it. True if the inbox is closed, or work waits that ends a step.
  const std::atomic<bool>* endingStep() const { return &ends_step_; }

  int numCloudsReplaced() const;
  int numCommandsDropped() const;

 private:
  void putCommand(Command command);
  // With the mutex held:
  void updateEndsStep();
  /// Reads the computer's clock; /clock has been observed already.
  std::int64_t readClock();
  void observe(std::int64_t now, std::int64_t steady);

  mutable std::mutex mutex_;
  std::condition_variable came_, answered_;
  ClockWatch clock_;
  const tf2::BufferCore& transforms_;
  const std::chrono::milliseconds patience_;
  std::string surface_frame_;
  std::optional<IncomingCloud> cloud_;
  std::deque<Command> commands_;
  std::string tools_refused_;
  std::deque<Job*> jobs_;
  bool was_woken_ = false, frame_wanted_ = false;
  std::atomic<bool> closed_{false}, ends_step_{false};
  int num_clouds_replaced_ = 0, num_commands_dropped_ = 0;
};

}  // namespace deformable_surface::node
