// Commands that came over ROS and wait for their step, and the forces and tools that they became. Apart from the stepper, which
// only says when a step begins.
#pragma once

#include "complaints.h"
#include "inbox.h"
#include "tool_commands.h"

#include "deformable_surface/simulation/simulation.h"

#include <tf2/buffer_core.h>

#include <deque>
#include <map>
#include <string>
#include <vector>

namespace deformable_surface::node {

class PendingCommands {
 public:
  PendingCommands(const simulation::WrenchParams& wrench, const tf2::BufferCore& transforms, Complaints& complaints)
      : wrench_(wrench), transforms_(transforms), complaints_(complaints), tools_(transforms) {}

  /// See ToolCommands.
  void setStanding(std::vector<Tool> tools) { tools_.setStanding(std::move(tools)); }
  /// Too many: the oldest are dropped.
  void append(std::vector<Command>&& commands);
  /// Drops those that count from before the stamp (ns).
  void dropBefore(std::int64_t stamp);
  void clear() { commands_.clear(); }
  /// The surface is another or at rest again: the forces and tools of before are gone.
  void forget();

  /// The forces and tools that commands became: what a snapshot of the surface needs to go on with them.
  struct Memory {
    std::map<std::string, double> forces;
    ToolCommands::Memory tools;
  };
  Memory memory() const { return {forces_, tools_.memory()}; }
  /// That of a surface which has been restored; what waits belongs to the run before it and is dropped.
  void restore(const Memory& memory);

  /// Applies what counts by the time at which a step begins (ns), in the order of the stamps, then of arrival, and moves the
  /// tools through that step.
  void apply(std::int64_t begin, simulation::Simulation& simulation, const std::string& frame);

  int numWaiting() const { return static_cast<int>(commands_.size()); }
  int numDropped() const { return num_dropped_; }
  std::uint64_t numApplied() const { return num_applied_; }

 private:
  void apply(const Command& command, simulation::Simulation& simulation, const std::string& frame);

  const simulation::WrenchParams wrench_;
  const tf2::BufferCore& transforms_;
  Complaints& complaints_;
  std::deque<Command> commands_;          // in the order of arrival
  std::map<std::string, double> forces_;  // when they end, s of simulation time
  ToolCommands tools_;
  int num_dropped_ = 0;
  std::uint64_t num_applied_ = 0;
};

}  // namespace deformable_surface::node
