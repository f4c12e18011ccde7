// One rollout: from the goal of the action to tools and forces on a copy of the surface, and from its steps to the result. It
// does not need the action server: it is tested without a roscore.
#pragma once

#include "deformable_surface/RolloutGoal.h"
#include "deformable_surface/RolloutResult.h"
#include "deformable_surface/ros/convert/step_schedule.h"
#include "deformable_surface/ros/convert/surface_output.h"
#include "deformable_surface/simulation/simulation.h"

#include <tf2/buffer_core.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace deformable_surface::node {

// As many as ~step accepts in a call.
constexpr std::uint64_t kMaxRolloutSteps = 1000000;
// Limits of a result: with the fields of a cloud, a few hundred megabytes.
constexpr std::uint64_t kMaxRolloutPoints = 4000000, kMaxRolloutSamples = 20000;

struct RolloutPlan {
  std::uint64_t first = 0, steps = 0;                    // the first step and the number of steps
  std::vector<std::uint64_t> cloud_steps, sample_steps;  // ascending: after so many steps of the rollout
  std::uint64_t most_points = kMaxRolloutPoints;         // of all clouds; points may be added in the steps
  std::uint8_t clouds = RolloutGoal::NONE;
  CloudId cloud;  // of the surface
};

/// Gives the goal's tools and forces to the copy. Throws InputError if the goal is not accepted; the copy is then unusable.
RolloutPlan prepareRollout(const RolloutGoal& goal, const std::string& surface_frame, const tf2::BufferCore& transforms,
                           simulation::Simulation& copy);

enum class RolloutEnd { kDone, kStopped, kFailed };

/// Takes the steps; fails where the clouds come to more points than the plan has. goes_on is called before each with the
/// progress, 0 to 1. Fills the result as far as it came.
RolloutEnd runRollout(const RolloutPlan& plan, const std::string& surface_frame, const StepSchedule& schedule,
                      const std::function<bool(double progress)>& goes_on, simulation::Simulation& copy, RolloutResult& result);

}  // namespace deformable_surface::node
