// The memory of a dynamics state: its lists and their content.
#include "../../src/simulation/dynamics_state.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::DynamicsState;

TEST(DynamicsState, CountsItsListsAndWhatTheyHold) {
  DynamicsState state;
  const std::size_t empty = state.bytes();
  EXPECT_EQ(empty, sizeof(DynamicsState));
  state.motion.points.positions.resize(100);
  EXPECT_EQ(state.bytes(), empty + 100 * sizeof(Vec3));
  state.motion.points.velocities.resize(100);
  state.motion.pinned.resize(100);
  EXPECT_EQ(state.bytes(), empty + 100 * (2 * sizeof(Vec3) + 1));

  DynamicsState tools;
  tools.settings.tools.resize(2);
  tools.settings.tools[1].path.resize(5);
  EXPECT_EQ(tools.bytes(), empty + 2 * sizeof(tool::ToolParams) + 5 * sizeof(tool::WaypointParams));

  DynamicsState grips;
  grips.holding.grips.resize(1);
  grips.holding.grips[0].points.resize(7);
  grips.holding.grips[0].places.resize(7);
  EXPECT_EQ(grips.bytes(), empty + sizeof(simulation::Grips::Grip) + 7 * sizeof(grips.holding.grips[0].points[0]) +
                               7 * sizeof(grips.holding.grips[0].places[0]));
}

TEST(DynamicsState, IsAValue) {
  DynamicsState state;
  state.waiting.steps = 7;
  state.motion.points.positions = {Vec3::UnitX()};
  const DynamicsState copy = state;
  state.motion.points.positions[0].setZero();
  EXPECT_EQ(copy.waiting.steps, 7u);
  EXPECT_EQ(copy.motion.points.positions[0], Vec3::UnitX());
}

}  // namespace
}  // namespace deformable_surface::test
