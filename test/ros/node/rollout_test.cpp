// Rollouts without a roscore.
#include "../../../src/ros/node/rollout.h"

#include "simulation/clouds.h"

#include <gtest/gtest.h>

namespace deformable_surface::node {
namespace {

using simulation::Simulation;

// Points may be added in the steps, so that what was accepted in the beginning comes to too many.
TEST(Rollout, EndsWhereItsCloudsHaveTooManyPoints) {
  const Simulation sheet(simulation::SceneParams(), test::sheetCloud(10));
  const double step = sheet.params().integrator.time_step;
  for (const std::uint8_t clouds : {RolloutGoal::SIMULATION_POINTS, RolloutGoal::FULL}) {
    RolloutGoal goal;
    goal.duration = 3.0 * step;
    goal.clouds = clouds;
    goal.cloud_times = {0.0, step, 2.0 * step, 3.0 * step};
    Simulation copy = sheet.fork();
    RolloutPlan plan = prepareRollout(goal, "base", tf2::BufferCore(), copy);
    for (const std::uint64_t most : {400, 399, 99}) {
      plan.most_points = most;
      RolloutResult result;
      Simulation run = copy.fork();
      const RolloutEnd end = runRollout(
          plan, "base", StepSchedule(step), [](double) { return true; }, run, result);
      EXPECT_EQ(end, most == 400 ? RolloutEnd::kDone : RolloutEnd::kFailed) << result.message;
      EXPECT_EQ(result.success, most == 400);
      EXPECT_EQ(result.clouds.size(), most / 100) << most;
      if (most == 399) {
        EXPECT_EQ(
            result.message,
            "cloud_times: found 400 points in 4 clouds, as points were added; accepted: up to 399 points in all (ended after "
            "step 3 of 3)");
      }
    }
  }
}

}  // namespace
}  // namespace deformable_surface::node
