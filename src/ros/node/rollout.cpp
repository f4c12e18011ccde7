#include "rollout.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/step_time.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/ros/convert/commands.h"
#include "deformable_surface/ros/convert/encode.h"
#include "deformable_surface/ros/convert/frames.h"
#include "deformable_surface/ros/convert/tool_commands.h"
#include "deformable_surface/ros/convert/tool_decoder.h"
#include "deformable_surface/ros/convert/tool_wrenches.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::node {
namespace {

// More than scenes use, and more than a message of a reasonable size holds.
constexpr std::size_t kMaxForces = 1000;

std::uint64_t toSteps(const std::string& what, double time, double step, std::uint64_t most) {
  const double steps = std::round(time / step);
  if (!(std::abs(time / step - steps) <= kTimeRounding * std::max(1.0, steps) && steps >= 0.0 &&
        steps <= static_cast<double>(most)))
    throw InputError(what + ": found " + formatReal(time) + "; accepted: multiples of integrator.time_step, " + formatReal(step) +
                     " s, up to " + formatReal(static_cast<double>(most) * step) + " s");
  return static_cast<std::uint64_t>(steps);
}

std::vector<std::uint64_t> toSteps(const std::string& what, const std::vector<double>& times, double step, std::uint64_t last) {
  if (times.empty()) return {last};
  std::vector<std::uint64_t> steps;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const std::string name = what + "[" + std::to_string(k) + "]";
    steps.push_back(toSteps(name, times[k], step, last));
    if (k > 0 && !(steps[k] > steps[k - 1]))
      throw InputError(name + ": found " + formatReal(times[k]) + ", which is not after " + formatReal(times[k - 1]) +
                       "; accepted: ascending times");
  }
  return steps;
}

void setTool(const ToolPath& given, const std::string& surface_frame, const tf2::BufferCore& transforms,
             simulation::Simulation& copy) {
  const Tool& command = given.tool;
  if (removeTools(command, copy)) return;
  if (given.times.empty() || given.times.size() != given.poses.size())
    throw InputError("found " + std::to_string(given.times.size()) + " times and " + std::to_string(given.poses.size()) +
                     " poses; accepted: as many of each, at least one");
  const tool::ToolParams* const before = findTool(copy, command.id);
  const double now = copy.time();
  tool::ToolParams tool = readTool(command);
  tool.start = now;
  const Eigen::Isometry3d transform =
      findTransform("tool.header.frame_id", command.header.frame_id, surface_frame, command.header.stamp, transforms);
  if (before) {
    // A tool that continues to grip keeps its points.
    if (before->mode == tool.mode && tool::isActive(*before, now)) tool.start = before->start;
    if (given.times[0] > 0.0) tool.path.push_back(makeWaypoint(now, tool::interpolate(before->path, now)));
  }
  for (std::size_t k = 0; k < given.times.size(); ++k) {
    if (!(given.times[k] >= 0.0))
      throw InputError("times[" + std::to_string(k) + "]: found " + formatReal(given.times[k]) + "; accepted: numbers >= 0 (s)");
    if (k > 0 && !(given.times[k] > given.times[k - 1]))
      throw InputError("times[" + std::to_string(k) + "]: found " + formatReal(given.times[k]) + " after " +
                       formatReal(given.times[k - 1]) + "; accepted: ascending times");
    const Eigen::Isometry3d pose = transform * readPose(given.poses[k]);
    tool.path.push_back(makeWaypoint(now + given.times[k], {pose.translation(), Eigen::Quaterniond(pose.linear())}));
  }
  copy.setTool(tool);
}

}  // namespace

RolloutPlan prepareRollout(const RolloutGoal& goal, const std::string& surface_frame, const tf2::BufferCore& transforms,
                           simulation::Simulation& copy) {
  const double step = copy.params().integrator.time_step;
  RolloutPlan plan;
  plan.first = copy.stepCount();
  plan.steps = toSteps("duration", goal.duration, step, kMaxRolloutSteps);
  if (plan.steps == 0) throw InputError("duration: found 0; accepted: a step, " + formatReal(step) + " s, and more");
  if (goal.clouds > RolloutGoal::FULL)
    throw InputError("clouds: found " + std::to_string(goal.clouds) + "; accepted: 0 (NONE), 1 (SIMULATION_POINTS), 2 (FULL)");
  plan.clouds = goal.clouds;
  if (goal.clouds == RolloutGoal::NONE && !goal.cloud_times.empty())
    throw InputError("cloud_times: found some with clouds: 0 (NONE); accepted: none, or clouds: 1 or 2");
  if (goal.clouds != RolloutGoal::NONE) plan.cloud_steps = toSteps("cloud_times", goal.cloud_times, step, plan.steps);
  plan.sample_steps = toSteps("times", goal.times, step, plan.steps);
  const std::uint64_t points = goal.clouds == RolloutGoal::FULL ? copy.input().positions.size() : copy.state().positions.size();
  if (points * plan.cloud_steps.size() > kMaxRolloutPoints)
    throw InputError("cloud_times: found " + std::to_string(plan.cloud_steps.size()) + " clouds of " + std::to_string(points) +
                     " points; accepted: up to " + std::to_string(kMaxRolloutPoints) + " points in all");
  if (plan.sample_steps.size() > kMaxRolloutSamples)
    throw InputError("times: found " + std::to_string(plan.sample_steps.size()) + "; accepted: up to " +
                     std::to_string(kMaxRolloutSamples));
  if (goal.forces.size() > kMaxForces)
    throw InputError("forces: found " + std::to_string(goal.forces.size()) + "; accepted: up to " + std::to_string(kMaxForces));

  for (const ToolPath& tool : goal.tools) {
    try {
      setTool(tool, surface_frame, transforms, copy);
    } catch (const InputError& error) {
      const std::string name = "tool " + quote(tool.tool.id.substr(0, 64)) + " ", problem = error.what();
      throw InputError(problem.compare(0, name.size(), name) == 0 ? problem : name + problem);
    }
  }
  for (const PointForce& force : goal.forces) copy.setForce(toForce(force, copy.time(), surface_frame, transforms));
  return plan;
}

RolloutEnd runRollout(const RolloutPlan& plan, const std::string& surface_frame, const StepSchedule& schedule,
                      const std::function<bool(double)>& goes_on, simulation::Simulation& copy, RolloutResult& result) {
  const SurfaceEncoder encoder(copy.input(), copy.params().output.normals, copy.params().output.error);
  auto cloud = plan.cloud_steps.begin();
  auto sample = plan.sample_steps.begin();
  std::uint64_t num_points = 0;  // of all clouds
  // Returns whether there was room.
  const auto record = [&](std::uint64_t step) {
    std_msgs::Header header;
    header.frame_id = surface_frame;
    header.stamp.fromNSec(static_cast<std::uint64_t>(schedule.begin(plan.first + step)));
    if (cloud != plan.cloud_steps.end() && *cloud == step) {
      ++cloud;
      const simulation::Surface* const full = plan.clouds == RolloutGoal::FULL ? &copy.surface(true) : nullptr;
      num_points += full ? full->positions.size() : copy.state().positions.size();
      if (num_points > plan.most_points) return false;
      result.clouds.emplace_back();
      result.clouds.back().header = header;
      if (full) {
        encoder.encode(*full, result.clouds.back());
      } else {
        encodeSimulationPoints(copy, result.clouds.back());
      }
    }
    if (sample != plan.sample_steps.end() && *sample == step) {
      ++sample;
      result.wrenches.push_back(makeToolWrenches(header, copy.toolReactions(), copy.pinReactions()));
      result.statistics.emplace_back();
      encodeStatistics(copy.statistics(), plan.cloud, result.statistics.back());
      result.statistics.back().header = header;
    }
    return true;
  };
  const auto end = [&](RolloutEnd how, const std::string& message) {
    result.success = how == RolloutEnd::kDone;
    result.message = message;
    result.state_hash = copy.stateHash();
    return how;
  };

  std::string notices;
  bool has_room = record(0);
  for (std::uint64_t step = 1; step <= plan.steps; ++step) {
    if (!goes_on(static_cast<double>(step - 1) / static_cast<double>(plan.steps)))
      return end(RolloutEnd::kStopped,
                 "stopped after " + std::to_string(step - 1) + " of " + std::to_string(plan.steps) + " steps");
    const simulation::StepOutcome outcome = copy.step();
    if (!outcome.ok && !goes_on(static_cast<double>(step - 1) / static_cast<double>(plan.steps)))
      return end(RolloutEnd::kStopped, "stopped in step " + std::to_string(step) + " of " + std::to_string(plan.steps));
    if (!outcome.ok) return end(RolloutEnd::kFailed, outcome.problem);
    if (notices.empty()) notices = outcome.notice;
    has_room = has_room && record(step);
    if (!has_room)
      return end(RolloutEnd::kFailed,
                 "cloud_times: found " + std::to_string(num_points) + " points in " + std::to_string(result.clouds.size() + 1) +
                     " clouds, as points were added; accepted: up to " + std::to_string(plan.most_points) +
                     " points in all (ended after step " + std::to_string(step) + " of " + std::to_string(plan.steps) + ")");
  }
  appendNotice(notices, copy.lastingNotices());
  return end(RolloutEnd::kDone, "took " + std::to_string(plan.steps) + " steps" + (notices.empty() ? "" : "; " + notices));
}

}  // namespace deformable_surface::node
