#include "pending_commands.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/ros/commands.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

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
  std::map<std::string, simulation::ForceParams> placed;
  for (auto command = commands_.begin(); command != later; ++command) {
    try {
      const simulation::ForceParams force = apply(*command, simulation, frame);
      placed[force.id] = force;
      ++num_applied_;
    } catch (const InputError& error) {
      complaints_.report(Complaint::kCommandRefused, error.what());
    }
  }
  commands_.erase(commands_.begin(), later);
  for (const auto& [id, force] : placed) checkPlace(force, simulation);
}

simulation::ForceParams PendingCommands::apply(const Command& command, simulation::Simulation& simulation,
                                               const std::string& frame) {
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
  return force;
}

/// Tells of a force that takes its points far from where it was put, or takes pinned ones only; once, until it is placed well.
void PendingCommands::checkPlace(const simulation::ForceParams& force, const simulation::Simulation& simulation) {
  if (force.force.isZero(0.0)) return;
  // The points within the radius, else the nearest one, as the step takes them.
  const Points& positions = simulation.state().positions;
  const std::vector<char>& pinned = simulation.pinned();
  Index nearest = 0, num_held = 0, num_pinned = 0;
  double nearest_distance = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < simulation.state().size(); ++i) {
    const double distance = (positions[i] - force.point).squaredNorm();
    if (distance < nearest_distance) {
      nearest = i;
      nearest_distance = distance;
    }
    if (!(force.radius > 0.0 && distance <= force.radius * force.radius)) continue;
    ++num_held;
    num_pinned += pinned[i] != 0;
  }
  std::string problem;
  if (force.radius > 0.0 && num_held == 0) {
    problem = "no simulation point lies within its radius of " + formatReal(force.radius) + " m; it acts on the nearest one, " +
              formatShort(std::sqrt(nearest_distance)) + " m from its point" + (pinned[nearest] ? ", which is pinned" : "");
  } else if (num_held == 0 ? pinned[nearest] : num_pinned == num_held) {
    problem = num_held > 1 ? "all " + std::to_string(num_held) + " simulation points that it acts on are pinned; it moves nothing"
                           : "the simulation point that it acts on is pinned; it moves nothing";
  }
  if (problem.empty()) {
    futile_.erase(force.id);
    return;
  }
  // Names that keep changing must not fill the memory.
  if (futile_.size() >= kMaxForces) futile_.clear();
  if (futile_.insert(force.id).second) complaints_.report(Complaint::kNotice, "force " + quote(force.id) + ": " + problem);
}

}  // namespace deformable_surface::node
