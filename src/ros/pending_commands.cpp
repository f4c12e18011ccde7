#include "pending_commands.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/ros/commands.h"

#include <algorithm>
#include <iterator>

namespace deformable_surface::node {
namespace {

// Far more than a scene uses; what comes over the network must not fill the memory.
constexpr std::size_t kMaxForces = 1000;
constexpr std::size_t kMaxWaiting = 100000;

}  // namespace

void PendingCommands::append(std::vector<Command>&& commands) {
  commands_.insert(commands_.end(), std::make_move_iterator(commands.begin()), std::make_move_iterator(commands.end()));
  for (; commands_.size() > kMaxWaiting; commands_.pop_front()) ++num_dropped_;
}

void PendingCommands::dropBefore(std::int64_t stamp) {
  const auto is_past = [&](const Command& command) { return command.stamp < stamp; };
  const auto kept = std::remove_if(commands_.begin(), commands_.end(), is_past);
  num_dropped_ += static_cast<int>(commands_.end() - kept);
  commands_.erase(kept, commands_.end());
}

void PendingCommands::apply(std::int64_t begin, simulation::Simulation& simulation, const std::string& frame) {
  const auto is_due = [&](const Command& command) { return command.stamp <= begin; };
  const auto later = std::stable_partition(commands_.begin(), commands_.end(), is_due);
  std::stable_sort(commands_.begin(), later, [](const Command& a, const Command& b) { return a.stamp < b.stamp; });
  for (auto command = commands_.begin(); command != later; ++command) {
    try {
      apply(*command, simulation, frame);
      ++num_applied_;
    } catch (const InputError& error) {
      complaints_.report(Complaint::kCommandRefused, error.what());
    }
  }
  commands_.erase(commands_.begin(), later);
  // Like gravity's frame by the latest transform: that of the step itself may come after it.
  for (const std::string& problem : tools_.move(ros::Time(), simulation, frame)) complaints_.report(Complaint::kWaiting, problem);
}

void PendingCommands::forget() {
  forces_.clear();
  tools_.forget();
}

void PendingCommands::restore(const Memory& memory) {
  clear();
  forces_ = memory.forces;
  tools_.setMemory(memory.tools);
}

void PendingCommands::apply(const Command& command, simulation::Simulation& simulation, const std::string& frame) {
  if (command.tool) return tools_.apply(*command.tool, simulation, frame);
  const double time = simulation.time();
  const simulation::ForceParams force = command.force ? toForce(*command.force, time, frame, transforms_)
                                                      : toForce(*command.wrench, time, frame, transforms_, wrench_);
  for (auto entry = forces_.begin(); entry != forces_.end();) {
    entry = entry->second <= time ? forces_.erase(entry) : std::next(entry);
  }
  if (forces_.size() >= kMaxForces && forces_.count(force.id) == 0) {
    throw InputError("force " + quote(force.id) + ": found " + std::to_string(forces_.size()) +
                     " forces at a time already; accepted: no more");
  }
  simulation.setForce(force);
  forces_[force.id] = force.force.isZero(0.0) ? time : force.end;
}

}  // namespace deformable_surface::node
