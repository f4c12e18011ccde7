#include "pending_commands.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/ros/convert/commands.h"
#include "deformable_surface/ros/convert/frames.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace deformable_surface::node {
namespace {

// Far more than a scene uses; messages must not fill the memory.
constexpr std::size_t kMaxForces = 1000;
constexpr std::size_t kMaxWaiting = 100000;

constexpr char kToolKey[] = "tool ";

// The target of a command: the next one with the same target replaces it.
std::string makeKey(const Command& command) {
  if (command.tool) return kToolKey + command.tool->id;
  return command.force ? "force " + command.force->id : kWrenchId;
}

// As input.lockstep has it.
std::string topicOf(const Command& command) { return command.force ? "force" : command.wrench ? "wrench" : "tools"; }

std::string describe(const Command& command) {
  if (command.wrench) return "wrench ";
  return command.force ? "force " + quote(command.force->id) + " " : "tool " + quote(command.tool->id) + " ";
}

}  // namespace

void PendingCommands::see(Command& command) const {
  if (command.is_stamped || (command.seen && command.seen->target == surface_frame_)) return;
  command.seen = seeTransform(command.header().frame_id, surface_frame_, transforms_);
}

// Its frame was unknown when it came: it took the latest transform in its step, which a replay does not know.
bool PendingCommands::hasGuessedFrame(const Command& command) const {
  const std::string frame = withoutSlash(command.header().frame_id);
  const bool has_pose = !command.tool || command.tool->action == Tool::ADD;
  return !command.is_stamped && !command.seen && has_pose && !frame.empty() && frame != surface_frame_;
}

void PendingCommands::setSurfaceFrame(const std::string& frame) {
  surface_frame_ = withoutSlash(frame);
  for (Command& command : commands_) see(command);
}

void PendingCommands::append(std::vector<Command>&& commands) {
  for (Command& command : commands) {
    if (!lockstep_.empty() && !command.is_stamped) {
      refuse(command, describe(command) + "found no stamp; accepted with input.lockstep: commands with a stamp");
      continue;
    }
    see(command);
    hear(command);
    reportWaiting(command);
    commands_.push_back(std::move(command));
  }
  for (; commands_.size() > kMaxWaiting; commands_.pop_front()) {
    ++num_dropped_;
    if (commands_.front().tool)
      tool_statuses_.reportRefused(*commands_.front().tool, "dropped: " + std::to_string(kMaxWaiting) + " newer commands wait");
  }
}

void PendingCommands::refuse(const Command& command, const std::string& reason) {
  warnings_.report(Warning::kCommandRefused, reason);
  if (command.tool) tool_statuses_.reportRefused(*command.tool, reason);
}

void PendingCommands::reportWaiting(const Command& command) {
  if (!command.tool) return;
  tool_statuses_.reportWaiting(*command.tool, surface_frame_.empty() ? "there is no surface yet" : "its step has not come yet");
}

void PendingCommands::hear(const Command& command) {
  std::int64_t& newest = newest_.emplace(topicOf(command), kNever).first->second;
  newest = std::max(newest, command.stamp);
}

bool PendingCommands::areCompleteAt(std::int64_t time) const {
  return std::all_of(lockstep_.begin(), lockstep_.end(), [&](const std::string& topic) {
    const auto newest = newest_.find(topic);
    return newest != newest_.end() && newest->second > time;
  });
}

std::string PendingCommands::missingFrame(std::int64_t begin, std::int64_t end, const std::string& frame) const {
  for (const Command& command : commands_) {
    const std_msgs::Header& header = command.header();
    if (command.stamp > begin || (command.tool && command.tool->action != Tool::ADD)) continue;
    if (!isKnown(header.frame_id, frame, header.stamp, transforms_)) return header.frame_id;
  }
  return tools_.missingFrame(ros::Time().fromNSec(static_cast<std::uint64_t>(end)), frame);
}

void PendingCommands::dropBefore(std::int64_t stamp) {
  const auto is_past = [&](const Command& command) { return command.stamp < stamp; };
  const auto kept = std::remove_if(commands_.begin(), commands_.end(), is_past);
  num_dropped_ += static_cast<int>(commands_.end() - kept);
  commands_.erase(kept, commands_.end());
  for (auto entry = without_frame_.begin(); entry != without_frame_.end();) {
    num_dropped_ += is_past(entry->second.command);
    entry = is_past(entry->second.command) ? without_frame_.erase(entry) : std::next(entry);
  }
}

std::vector<std::string> PendingCommands::waitingForces() const {
  std::vector<std::string> ids;
  std::set<std::string> known;
  const auto list = [&](const Command& command) {
    if (command.force && known.insert(command.force->id).second) ids.push_back(command.force->id);
  };
  for (const auto& [key, waiting] : without_frame_) list(waiting.command);
  for (const Command& command : commands_) list(command);
  return ids;
}

void PendingCommands::keepSince(std::int64_t stamp) {
  kept_.clear();
  keep_since_ = stamp;
}

void PendingCommands::takeBack() {
  commands_.insert(commands_.begin(), kept_.begin(), kept_.end());
  forgetKept();
}

void PendingCommands::forgetKept() {
  kept_.clear();
  keep_since_ = std::numeric_limits<std::int64_t>::max();
}

void PendingCommands::clear() {
  newest_.clear();
  tool_statuses_.clear();
  kept_.clear();
  commands_.clear();
  without_frame_.clear();
}

void PendingCommands::apply(std::int64_t begin, std::int64_t end, simulation::Simulation& simulation, const std::string& frame) {
  // Each is taken out before it is carried out: an exception loses that one, and no other is carried out twice.
  // Commands may be younger than the ones that wait now.
  std::vector<std::string> keys;
  for (const auto& [key, waiting] : without_frame_) keys.push_back(key);
  for (const std::string& key : keys) {
    const Waiting waiting = std::move(without_frame_.extract(key).mapped());
    carryOut(waiting.command, waiting.give_up, simulation, frame);
  }

  const auto is_due = [&](const Command& command) { return command.stamp <= begin; };
  const auto later = std::stable_partition(commands_.begin(), commands_.end(), is_due);
  std::stable_sort(commands_.begin(), later, [](const Command& a, const Command& b) { return a.stamp < b.stamp; });
  for (auto num_due = later - commands_.begin(); num_due > 0; --num_due) {
    const Command command = std::move(commands_.front());
    commands_.pop_front();
    carryOut(command, SteadyClock::now() + kTransformPatience, simulation, frame);
  }
  last_begin_ = begin;
  const ros::Time stamp = ros::Time().fromNSec(static_cast<std::uint64_t>(end));
  for (const std::string& problem : tools_.move(stamp, simulation, frame)) warnings_.report(Warning::kWaiting, problem);
}

void PendingCommands::carryOut(const Command& command, SteadyClock::time_point give_up, simulation::Simulation& simulation,
                               const std::string& frame) {
  const std::string key = makeKey(command);
  // A tool that has not been added yet is deleted by dropping its command.
  const bool cancels = command.tool && command.tool->action == Tool::DELETE && without_frame_.erase(key) > 0;
  num_dropped_ += cancels;
  const auto older = without_frame_.find(key);
  const bool is_kept = command.stamp >= keep_since_ && kept_.size() < kMaxWaiting;
  try {
    apply(command, simulation, frame);
    ++num_applied_;
    if (command.tool) tool_statuses_.reportAccepted(*command.tool, simulation.stepCount());
    if (is_kept) kept_.push_back(command);
    num_late_ += command.stamp <= last_begin_ || hasGuessedFrame(command);
  } catch (const FrameError& error) {
    // The first of several commands sets how long they wait.
    if (older != without_frame_.end()) give_up = older->second.give_up;
    if (SteadyClock::now() < give_up && (older != without_frame_.end() || without_frame_.size() < kMaxForces)) {
      warnings_.report(Warning::kWaiting, std::string(error.what()) + "; the command waits for it");
      if (command.tool) tool_statuses_.reportWaiting(*command.tool, error.what());
      num_dropped_ += older != without_frame_.end();
      without_frame_[key] = {command, give_up};
      return;
    }
    refuse(command, error.what());
  } catch (const InputError& error) {
    if (is_kept) kept_.push_back(command);
    const std::string rest = is_kept ? " (by the surface that is there; it is tried again on the one that is being built)" : "";
    if (!cancels) {
      refuse(command, error.what() + rest);
    } else {
      tool_statuses_.reportAccepted(*command.tool, simulation.stepCount());
    }
    return;  // the waiting command stays valid
  }
  if (command.tool && command.tool->action == Tool::DELETEALL) {
    const auto is_tool = [](const auto& entry) { return entry.first.compare(0, sizeof kToolKey - 1, kToolKey) == 0; };
    for (auto entry = without_frame_.begin(); entry != without_frame_.end();) {
      num_dropped_ += is_tool(*entry);
      entry = is_tool(*entry) ? without_frame_.erase(entry) : std::next(entry);
    }
  } else {
    num_dropped_ += static_cast<int>(without_frame_.erase(key));
  }
}

void PendingCommands::forget() {
  newest_.clear();
  tool_statuses_.clear();
  const auto keep = [&](const Command& command) {
    hear(command);
    reportWaiting(command);
  };
  for (const auto& [key, waiting] : without_frame_) keep(waiting.command);
  for (const Command& command : commands_) keep(command);
  forces_.clear();
  tools_.forget();
  last_begin_ = kNever;
}

void PendingCommands::restore(const Memory& memory) {
  clear();
  last_begin_ = kNever;
  forces_ = memory.forces;
  tools_.setMemory(memory.tools);
}

void PendingCommands::apply(const Command& command, simulation::Simulation& simulation, const std::string& frame) {
  const SeenTransform* const seen = command.seen ? &*command.seen : nullptr;
  if (command.tool) return tools_.apply(*command.tool, simulation, frame, seen);
  const double time = simulation.time();
  const simulation::ForceParams force = command.force ? toForce(*command.force, time, frame, transforms_, seen)
                                                      : toForce(*command.wrench, time, frame, transforms_, wrench_, seen);
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
