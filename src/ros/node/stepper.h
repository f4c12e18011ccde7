// The simulation thread: takes the steps of the surface when they are due, hands over moments for display, and changes to another
// surface when one was built. Only this thread touches the simulation.
#pragma once

#include "cloud_worker.h"
#include "frame_thread.h"
#include "hold.h"
#include "inbox.h"
#include "pending_choice.h"
#include "pending_commands.h"
#include "publishers.h"
#include "snapshot_shelf.h"
#include "waiting_clouds.h"
#include "warning_log.h"
#include "wrench_publishers.h"

#include "deformable_surface/ros/convert/step_schedule.h"
#include "deformable_surface/simulation/simulation.h"
#include "deformable_surface/simulation/tracking_watch.h"

#include <tf2/buffer_core.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace deformable_surface::node {

/// The state of the simulation, for diagnostics.
struct StepperStatus {
  std::string state = "waiting for a cloud";
  bool is_failed = false;                         // the last step failed
  double time_step = 0.0, simulation_time = 0.0;  // s
  std::uint64_t step = 0;
  std::uint64_t steps_taken = 0;  // of all surfaces
  int clouds_received = 0, clouds_accepted = 0, clouds_ignored = 0, clouds_tracked = 0, clouds_late = 0, clouds_dropped = 0;
  int clouds_again = 0;  // accepted clouds that equal the one of the surface
  int frames_dropped = 0, jumps_back = 0;
  std::uint64_t commands_applied = 0, commands_late = 0;
  int commands_waiting = 0, commands_dropped = 0;
  std::string silent_tools;     // ids
  bool has_snapped = false;     // see Simulation::hasSnapped()
  std::string lost;             // how few points of the surface the tracked cloud shows; empty: it is not lost
  double lag = 0.0;             // s that the next step is late; 0 where none is due, as in a pause
  double time_let_go = 0.0;     // s of the ROS clock for which no steps were taken, since they took too long
  double time_in_calls = 0.0;   // the same, since a call of a service did
  double time_in_builds = 0.0;  // from the stamps of clouds to the first steps of the surfaces made from them
  std::string accuracy;         // the choice for the accuracy target, and its reason; empty without a target
};

class Stepper {
 public:
  Stepper(const simulation::SceneParams& params, Inbox& inbox, CloudWorker& worker, const Publishers& publishers,
          FrameThread& frames, WrenchPublishers& wrenches, const tf2::BufferCore& transforms, WarningLog& warnings);

  /// See ToolCommands. Before the first turn.
  void setStanding(std::vector<Tool> tools) { commands_.setStanding(std::move(tools)); }
  /// See ToolCommands.
  Index pinToFrame(const std_msgs::Header& header, const geometry::Region& region) {
    return commands_.pinToFrame(header, region, *simulation_, frame_);
  }
  std::vector<std::string> waitingForces() const { return commands_.waitingForces(); }

  /// Waits for the next thing to do, but not beyond the given time, and does it. Returns false when the inbox is closed.
  bool turn(Inbox::SteadyTime until);

  // For services; only in work given to the inbox.
  /// Null while there is no surface.
  simulation::Simulation* simulation() { return simulation_.get(); }
  const std::string& frame() const { return frame_; }
  const CloudId& cloud() const { return cloud_; }
  /// By ~pause, or after a failed step until ~pause false, a reset or a new cloud.
  bool isPaused() const { return is_paused_ || is_failed_; }
  void setPaused(bool paused);
  void reset();
  /// Takes up to count steps now and returns how many; fewer if one failed or the node is shutting down.
  std::uint32_t takeSteps(std::uint32_t count);
  /// Shows all of it after a call that changed it. Later subscribers get it, too: it is latched.
  void showResult();
  /// The state in which steps stopped, for those who do not have it. Later subscribers get it, too.
  void showStop();
  /// Waits until the last result is published. For any thread but the one of the steps.
  void waitForResult() { frames_.waitForResult(); }
  /// Stores the surface as it is now; restores it with its forces and tools. Both throw InputError.
  void keepSnapshot(const std::string& name);
  void restoreSnapshot(const std::string& name);
  SnapshotShelf& snapshots() { return snapshots_; }
  const simulation::SceneParams& params() const { return params_; }
  /// For the present surface and later ones. Throws InputError, and changes nothing, if a value differs that may not change at
  /// run time.
  void setParams(const simulation::SceneParams& params);
  /// call: called when a snapshot has restored other values.
  void onParams(std::function<void()> call) { on_params_ = std::move(call); }
  /// The stamps of a rollout that begins now with this step.
  StepSchedule scheduleFrom(std::uint64_t step) const;
  /// Takes no step until letGo() or replaceHeld(): a copy of the surface is being worked on and will replace it.
  Hold::Id hold() { return hold_.begin(); }
  /// Does nothing if that hold has ended.
  void letGo(Hold::Id id);
  /// Throws InputError, and changes nothing, if a reset, a snapshot or a cloud has ended that hold.
  void replaceHeld(Hold::Id id, std::unique_ptr<simulation::Simulation> simulation);
  /// Throws InputError while it is held; for calls that would change it.
  void requireFree() const;
  /// The reason why no step can be taken now; empty if there is none.
  std::string obstacle();
  /// Whether a surface is being built from a cloud.
  bool isBuilding() const { return building_.has_value(); }

  StepperStatus status() const;

  /// For any thread: s of wall time since the running step began; 0 without one.
  double secondsInStep() const;

 private:
  // In stepper_clock.cpp:
  void handleClock(const ClockChange& clock);
  void tellWhatLasted();
  void restart(std::int64_t now);
  std::int64_t delayed(std::int64_t clock) const;
  void letGoOfLag(double call_seconds);
  void beginAnew(std::int64_t zero);

  // In stepper_clouds.cpp:
  void handleClouds();
  WaitingClouds::Answer prepare(const IncomingCloud& incoming, bool is_patient, CloudWork& work);
  void takeResult(CloudResult&& result);
  void observeReady();
  void begin(CloudResult&& result);
  /// params_revision: of the values that it was built with.
  void adopt(std::unique_ptr<simulation::Simulation> simulation, std::unique_ptr<simulation::Simulation> viewer,
             std::uint64_t params_revision);
  void setSurfaceFrame(const std::string& frame);
  void reportBuilding();
  std::int64_t arrivalOf(const IncomingCloud& incoming) const;
  std::int64_t stampOf(const IncomingCloud& incoming) const;
  bool isAgain(const CloudWork& work) const;
  bool isTracking() const;

  // In stepper_choice.cpp:
  void handleChoice();
  void resetSurface();
  std::string describeAccuracy() const;

  // In stepper_output.cpp:
  Moment makeMoment();
  void show();
  void show(std::int64_t stamp, bool is_result = false);
  std::int64_t outputStamp() const;
  bool isWanted() const;
  void publishWrenches();
  void publishToolStatuses();

  bool isLockstep() const { return !params_.input.lockstep.empty(); }
  /// In lockstep: whether everything that the step waits for has come.
  bool hasAllCommands() const;
  bool hasFrames();
  // In lockstep time only passes with the commands.
  void skipTo(std::int64_t now, std::uint64_t step);
  void resumeAt(std::int64_t now, std::uint64_t step);

  bool isDue() const;
  /// Whether the next step begins more than a step later, as after a jump back to before the stamp of the cloud.
  bool waitsUntilLater(std::int64_t now) const;
  bool canRest() const;
  bool takeStep();
  std::int64_t countFrames() const;
  Eigen::Isometry3d findGravityTransform() const;
  bool updateGravity();
  Inbox::SteadyTime nextDeadline(Inbox::SteadyTime until) const;
  std::int64_t timeStep() const { return schedule_.stamp(1) - schedule_.stamp(0); }

  // A stamp further ahead than clocks of different computers ever differ is a mistake. It would stop the surface for that long.
  static constexpr std::int64_t kMaxAhead = 3600'000'000'000;
  // Lag above this limit on the computer's clock, ns, is dropped, not caught up.
  static constexpr std::int64_t kMaxLag = 250'000'000;

  simulation::SceneParams params_;
  std::function<void()> on_params_;
  Inbox& inbox_;
  CloudWorker& worker_;
  const Publishers& publishers_;  // only functions that any thread may call
  FrameThread& frames_;
  WrenchPublishers& wrenches_;
  const tf2::BufferCore& transforms_;
  WarningLog& warnings_;
  const bool is_clock_simulated_;
  const std::int64_t delay_;  // ns that steps stay behind the clock

  std::unique_ptr<simulation::Simulation> simulation_;
  std::unique_ptr<simulation::Simulation> new_viewer_;  // of it, until it is shown for the first time
  // The surface of the same cloud that trials for an accuracy target choose for while an untried one runs; what they made, to
  // begin with at the next reset.
  std::unique_ptr<PendingChoice> choosing_;
  std::optional<PendingChoice::Made> chosen_;
  std::string trials_;  // what trials found, where the surface is not the one that they chose; else empty
  std::string frame_;
  CloudId cloud_;
  std::unique_ptr<cloud::PointCloud> unfiltered_;  // the cloud before the filters; null: the simulation's input itself
  StepSchedule schedule_;
  std::int64_t now_ = 0;  // ns of the ROS clock, less the delay; 0 = there is no valid time yet
  WaitingClouds clouds_;
  struct ReadyCloud {
    std::int64_t stamp;  // ns
    std::shared_ptr<const simulation::ObservedCloud> cloud;
  };
  std::deque<ReadyCloud> ready_;  // to be tracked from the step at their stamp on
  struct Building {
    Inbox::SteadyTime begin;
    Index points = 0;
    bool is_reported = false;
  };
  std::optional<Building> building_;
  // Of params_; of those that the last build, and the last trials in the background, began with.
  std::uint64_t params_revision_ = 0, built_revision_ = 0, chosen_revision_ = 0;
  PendingCommands commands_;
  SnapshotShelf snapshots_;                         // of this surface
  std::optional<Inbox::SteadyTime> missing_since_;  // in lockstep: tf does not know a frame that the next step needs
  bool is_paused_ = false;                          // asked for
  bool was_paused_ = false;                         // at some time since the surface was at rest
  bool is_failed_ = false, is_gravity_known_ = false;
  Mat3 gravity_rotation_ = Mat3::Identity();  // from gravity_frame, if it is known: the last one
  Hold hold_;
  simulation::TrackingWatch tracking_;            // since the surface was at rest
  bool is_as_built_ = false;                      // only its cloud and params_ have shaped the surface
  double time_input_ = 0.0, step_seconds_ = 0.0;  // s of wall time: the commands of the last step, all of it
  double call_seconds_ = 0.0;                     // of the services called in the last turn

  // Frames lie on simulation time; this is the last one that was due.
  std::int64_t last_frame_ = 0;
  bool is_frame_due_ = false;
  std::uint64_t shown_revision_ = 0, shown_surface_revision_ = 0;  // of the simulation, when it was handed over last
  Inbox::SteadyTime last_turn_;
  std::atomic<std::chrono::steady_clock::rep> step_began_{0};  // 0: none is under way

  StepperStatus counts_;
};

}  // namespace deformable_surface::node
