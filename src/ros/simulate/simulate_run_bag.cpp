// The part of a run that reads its bag.
#include "simulate_run.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/ros/convert/commands.h"
#include "deformable_surface/ros/convert/frames.h"

#include <utility>
#include <variant>

namespace deformable_surface::node {

using simulation::Simulation;

// The bag's messages in the order of their stamps, and the steps between them.
void Run::playBag() {
  std::vector<InputBag::Event> waiting;  // commands that came before the first cloud
  for (const auto& [stamp, entry] : bag_->entries()) {
    if (status_ != kDone || (simulation_ && stamp >= end_)) {
      if (not_taken_++ == 0) first_not_taken_ = stamp;
      continue;
    }
    InputBag::Event event = bag_->read(stamp, entry);
    if (auto* cloud = std::get_if<DecodedCloud>(&event.message)) {
      takeCloud(std::move(*cloud), event.stamp);
      if (simulation_) {
        for (const InputBag::Event& command : waiting) takeCommand(command);
        waiting.clear();
      }
    } else if (simulation_) {
      takeCommand(event);
    } else {
      waiting.push_back(std::move(event));
    }
  }
  if (!simulation_) throw InputError(options_.bag_in + ": found no cloud that can be simulated; accepted: at least one");
}

// A cloud that is refused changes nothing.
void Run::takeCloud(DecodedCloud decoded, std::int64_t stamp) {
  if (simulation_ && params_.input.policy == simulation::InputPolicy::kIgnore) return;
  if (simulation_ && params_.input.policy == simulation::InputPolicy::kTrack) return track(decoded, stamp);
  std::unique_ptr<Simulation> simulation;
  const std::string cloud_frame = decoded.header.frame_id;
  try {
    if (!decoded.ok()) throw InputError(decoded.problem);
    bringInto(findFrame(cloud_frame), stamp, decoded);
    const Timer timer;
    simulation = build(std::move(decoded.cloud), cloud_frame, stamp);
    set_up_seconds_ += timer.seconds();
  } catch (const InputError& error) {
    return reportRefusal("cloud", stamp, error);
  } catch (const Interrupted&) {
    if (!simulation_) throw;
    status_ = kInterrupted;  // the run keeps what it has of the old surface
    return;
  }
  // The old surface takes the steps that end before the new one is there.
  if (simulation_) stepUntil(stamp);
  if (status_ != kDone) return;
  begin(std::move(simulation), cloud_frame, stamp);
  ++clouds_;
}

void Run::track(DecodedCloud& decoded, std::int64_t stamp) {
  while (canStep() && now() < stamp) step();
  try {
    if (!decoded.ok()) throw InputError(decoded.problem);
    bringInto(frame_, stamp, decoded);
    filter(decoded.cloud);
    simulation_->observe(decoded.cloud);
    ++followed_;
  } catch (const InputError& error) {
    reportRefusal("cloud", stamp, error);
  }
}

// Takes effect at the first step that begins at or after the stamp.
void Run::takeCommand(const InputBag::Event& event) {
  while (canStep() && now() < event.stamp) step();
  const SeenTransform* const seen = event.seen ? &*event.seen : nullptr;
  try {
    if (!event.unknown_frame.empty())
      throw InputError("header.frame_id: found " + quote(event.unknown_frame) + " without a stamp, and no transform to " +
                       quote(frame_) + " when it was recorded or soon after; accepted: frames that tf knows then");
    if (const auto* force = std::get_if<PointForce>(&event.message)) {
      simulation_->setForce(toForce(*force, simulation_->time(), frame_, bag_->transforms(), seen));
      ++forces_;
    } else if (const auto* wrench = std::get_if<geometry_msgs::WrenchStamped>(&event.message)) {
      simulation_->setForce(toForce(*wrench, simulation_->time(), frame_, bag_->transforms(), params_.force, seen));
      ++wrenches_;
    } else {
      const DecodedTools& decoded = std::get<DecodedTools>(event.message);
      if (!decoded.ok()) throw InputError(decoded.problem);
      for (const Tool& tool : decoded.tools) tool_commands_->apply(tool, *simulation_, frame_, seen);
      tools_ += decoded.tools.size();
    }
  } catch (const InputError& error) {
    reportRefusal("command", event.stamp, error);
  }
}

// A recorded cloud, by the transforms of its bag.
void Run::bringInto(const std::string& frame, std::int64_t stamp, DecodedCloud& decoded) const {
  ros::Time time;
  time.fromNSec(static_cast<std::uint64_t>(stamp));
  transformCloud(findTransform("header.frame_id", decoded.header.frame_id, frame, time, bag_->transforms()), decoded.cloud);
}

// Counts of what was used of the bag, and what was not.
void Run::noteBag() {
  note("taken from " + options_.bag_in + ": clouds " + std::to_string(clouds_) +
       (followed_ > 0 ? " (" + std::to_string(followed_) + " later ones were followed)" : "") + ", forces " +
       std::to_string(forces_) + ", wrenches " + std::to_string(wrenches_) + ", commands to tools " + std::to_string(tools_));
  if (not_taken_ == 0) return;
  const auto findTime = [this](std::int64_t stamp) { return formatShort(static_cast<double>(stamp - run_start_) * 1e-9); };
  note("not taken from " + options_.bag_in + ": " + std::to_string(not_taken_) + " of " + std::to_string(bag_->entries().size()) +
       " clouds and commands, from " + findTime(first_not_taken_) + " to " + findTime(bag_->entries().rbegin()->first) +
       " s after the first cloud; the run ended at " + formatShort(runTime()) + " s; --duration S sets its end");
}

}  // namespace deformable_surface::node
