// Commands that came over ROS and wait for their step, and the forces and tools made from them. The stepper
// only reports when a step begins.
#pragma once

#include "inbox.h"
#include "tool_statuses.h"
#include "warning_log.h"

#include "deformable_surface/ros/convert/tool_commands.h"
#include "deformable_surface/simulation/simulation.h"

#include <tf2/buffer_core.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace deformable_surface::node {

class PendingCommands {
 public:
  PendingCommands(const simulation::WrenchParams& wrench, const simulation::InputParams& input, const tf2::BufferCore& transforms,
                  WarningLog& warnings)
      : wrench_(wrench),
        lockstep_(simulation::splitNames(input.lockstep)),
        transforms_(transforms),
        warnings_(warnings),
        tools_(transforms, input.tool_timeout) {}

  /// See ToolCommands.
  void setStanding(std::vector<Tool> tools) { tools_.setStanding(std::move(tools)); }
  Index pinToFrame(const std_msgs::Header& header, const geometry::Region& region, simulation::Simulation& simulation,
                   const std::string& frame) {
    return tools_.pinToFrame(header, region, simulation, frame);
  }
  /// Sets the frame of the surface that commands are for. Earlier commands without a stamp take their transforms now.
  void setSurfaceFrame(const std::string& frame);
  /// If there are too many, the oldest are dropped. In lockstep commands without a stamp are refused.
  void append(std::vector<Command>&& commands);
  /// Drops commands that count from before the stamp (ns).
  void dropBefore(std::int64_t stamp);
  void clear();
  /// Commands that count from the stamp (ns) on are kept when they are applied, for a surface that will begin then, including
  /// those that the present surface cannot use.
  void keepSince(std::int64_t stamp);
  /// The kept commands wait again.
  void takeBack();
  void forgetKept();
  /// Later steps count anew: no command is late by the beginning of the last step.
  void forgetSteps() { last_begin_ = kNever; }
  /// The surface is new or at rest again: its former forces and tools are gone.
  void forget();

  /// The forces and tools made from commands: a snapshot of the surface needs them.
  struct Memory {
    std::map<std::string, double> forces;
    ToolCommands::Memory tools;
  };
  Memory memory() const { return {forces_, tools_.memory()}; }
  /// For a surface that was restored. Waiting commands belong to the run before and are dropped.
  void restore(const Memory& memory);

  /// Applies commands that count by the time at which a step begins (ns), in the order of stamps, then of arrival, and moves the
  /// tools through that step, to its end. A command whose transform is unknown waits for it, for a while, unless a newer one
  /// for the same force or tool replaces it.
  void apply(std::int64_t begin, std::int64_t end, simulation::Simulation& simulation, const std::string& frame);
  /// Whether a step may need work before it without a new command.
  bool isMoving() const { return numWaiting() > 0 || tools_.isMoving(); }

  /// In lockstep: whether every topic that steps wait for has brought a command stamped after the time (ns).
  bool areCompleteAt(std::int64_t time) const;
  /// In lockstep: a frame that a command for the step, or a tool in it, needs and tf does not know yet; empty if there is none.
  std::string missingFrame(std::int64_t begin, std::int64_t end, const std::string& frame) const;

  ToolStatuses& toolStatuses() { return tool_statuses_; }
  std::set<std::string> silentTools() const { return tools_.silent(); }

  /// The ids of the waiting forces, each once, in the order of arrival.
  std::vector<std::string> waitingForces() const;
  int numWaiting() const { return static_cast<int>(commands_.size() + without_frame_.size()); }
  int numDropped() const { return num_dropped_; }
  /// How many were applied after the step in which they should have been, or with a transform that was unknown when
  /// they came.
  std::uint64_t numLate() const { return num_late_; }
  std::uint64_t numApplied() const { return num_applied_; }

 private:
  using SteadyClock = std::chrono::steady_clock;
  struct Waiting {
    Command command;
    SteadyClock::time_point give_up;
  };
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();

  /// give_up: until when it waits for its transform.
  void carryOut(const Command& command, SteadyClock::time_point give_up, simulation::Simulation& simulation,
                const std::string& frame);
  void apply(const Command& command, simulation::Simulation& simulation, const std::string& frame);
  void see(Command& command) const;
  void hear(const Command& command);
  void reportWaiting(const Command& command);
  void refuse(const Command& command, const std::string& reason);
  bool hasGuessedFrame(const Command& command) const;

  const simulation::WrenchParams wrench_;
  const std::vector<std::string> lockstep_;     // topics; none: steps follow the clock
  std::map<std::string, std::int64_t> newest_;  // by topic: ns, the latest stamp that came
  const tf2::BufferCore& transforms_;
  WarningLog& warnings_;
  std::string surface_frame_;
  std::deque<Command> commands_;  // in the order of arrival
  std::deque<Command> kept_;      // applied, see keepSince()
  std::int64_t keep_since_ = std::numeric_limits<std::int64_t>::max();
  std::map<std::string, double> forces_;  // when they end, s of simulation time
  ToolCommands tools_;
  ToolStatuses tool_statuses_;
  std::map<std::string, Waiting> without_frame_;  // the newest for each force and tool
  std::int64_t last_begin_ = kNever;              // of the last step (ns)
  int num_dropped_ = 0;
  std::uint64_t num_applied_ = 0, num_late_ = 0;
};

}  // namespace deformable_surface::node
