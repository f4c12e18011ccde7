// The mechanics alone. States and commands are values. A fork, and a run after a step is undone, continue the original run.
#include "../../src/simulation/dynamics.h"
#include "../../src/simulation/state_hash.h"
#include "clouds.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::Command;
using simulation::Dynamics;
using simulation::DynamicsState;
using simulation::SceneParams;
namespace command = simulation::command;

std::unique_ptr<Dynamics> makeDynamics(const SceneParams& params) {
  return std::make_unique<Dynamics>(params, simulation::buildRestSurface(params, sheetCloud(12)));
}

SceneParams smallSheet() {
  SceneParams p = hangingSheet();
  p.simplification = cloud::SimplificationParams();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  return p;
}

tool::ToolParams makeBall() {
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.2;
  ball.path.resize(1);
  ball.path[0].position = Vec3(0.5, 0.5, -0.25);
  return ball;
}

// The edge that hangs free.
geometry::Region makeEdge() {
  geometry::Region edge;
  edge.min = Vec3(0.9, -2.0, -1.0);
  edge.max = Vec3(1.1, 2.0, 1.0);
  return edge;
}

// One of each command that a sheet accepts.
std::vector<Command> makeCommands() {
  simulation::MaterialChangeParams soft;
  soft.young_modulus = 2e5;
  return {command::SetForce{{"pull", Vec3(1.0, 0.5, 0.0), Vec3(0.0, 0.0, 1.0), 0.2, 0.0, 1e300}},
          command::SetTool{makeBall()},
          command::PinAlong{"carried", makeEdge(), {{0.0, Vec3::Zero()}, {1.0, Vec3(0.0, 0.0, 0.1)}}},
          command::SetGravity{Vec3(0.0, 1.0, -5.0)},
          command::SetMaterial{{}, soft},
          command::SetDamping{2.0}};
}

std::uint64_t runSteps(Dynamics& dynamics, int steps) {
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(dynamics.step().ok);
  return simulation::hashState(dynamics.state());
}

TEST(Dynamics, ForksAndRestoredStatesGoOnBitForBitAfterEveryCommand) {
  const auto dynamics = makeDynamics(smallSheet());
  for (const Command& given : makeCommands()) {
    SCOPED_TRACE(given.index());
    EXPECT_TRUE(dynamics->apply(given).done);
    runSteps(*dynamics, 2);
    const DynamicsState saved = dynamics->save();
    const auto fork = dynamics->fork();
    const std::uint64_t end = runSteps(*dynamics, 3);
    EXPECT_EQ(runSteps(*fork, 3), end);
    dynamics->restore(saved);
    EXPECT_EQ(runSteps(*dynamics, 3), end);
    EXPECT_EQ(dynamics->stepCount(), saved.waiting.steps + 3);
  }
}

TEST(Dynamics, GivesTheSameCommandsTheSameEffectOnAnotherSurface) {
  const auto one = makeDynamics(smallSheet()), other = makeDynamics(smallSheet());
  for (const Command& given : makeCommands())
    for (Dynamics* dynamics : {one.get(), other.get()}) dynamics->apply(given);
  EXPECT_EQ(runSteps(*one, 4), runSteps(*other, 4));
}

TEST(Dynamics, TakesAStepBackAsIfItHadNotBeenTaken) {
  const auto dynamics = makeDynamics(smallSheet());
  for (const Command& given : makeCommands()) dynamics->apply(given);
  const std::uint64_t before = runSteps(*dynamics, 3), after = runSteps(*dynamics, 1);
  dynamics->undoStep();
  EXPECT_EQ(simulation::hashState(dynamics->state()), before);
  EXPECT_EQ(dynamics->stepCount(), 3u);
  EXPECT_EQ(runSteps(*dynamics, 1), after);
}

TEST(Dynamics, SaysWhatACommandChanged) {
  const auto dynamics = makeDynamics(smallSheet());
  const simulation::Changes pinned = dynamics->apply(command::Pin{makeEdge()});
  EXPECT_TRUE(pinned.everywhere);
  EXPECT_GT(pinned.points, 0);
  EXPECT_FALSE(pinned.loads);
  EXPECT_TRUE(dynamics->apply(command::SetTool{makeBall()}).loads);
  EXPECT_FALSE(dynamics->apply(command::RemoveTool{"none"}).done);
  EXPECT_FALSE(dynamics->apply(command::SetGravity{dynamics->params().gravity}).done);
  EXPECT_TRUE(dynamics->apply(command::SetState{dynamics->state()}).moved);
}

TEST(Dynamics, HasAnotherRevisionAfterWhatChangedAnything) {
  const auto dynamics = makeDynamics(smallSheet());
  std::uint64_t last = dynamics->revision();
  for (const Command& given : makeCommands()) {
    dynamics->apply(given);
    EXPECT_NE(dynamics->revision(), last) << given.index();
    last = dynamics->revision();
  }
  dynamics->apply(command::RemoveTool{"none"});
  EXPECT_EQ(dynamics->revision(), last);
  runSteps(*dynamics, 1);
  EXPECT_NE(dynamics->revision(), last);
}

TEST(Dynamics, BeginsAnewAsItBeganFirst) {
  const auto dynamics = makeDynamics(smallSheet());
  const std::uint64_t first = runSteps(*dynamics, 3);
  for (const Command& given : makeCommands()) dynamics->apply(given);
  runSteps(*dynamics, 3);
  dynamics->reset();
  EXPECT_EQ(runSteps(*dynamics, 3), first);
}

TEST(DynamicsState, CountsWhatItHolds) {
  const auto dynamics = makeDynamics(smallSheet());
  const DynamicsState saved = dynamics->save();
  const std::size_t points = saved.motion.points.positions.size();
  EXPECT_GE(saved.bytes(), sizeof(DynamicsState) + 2 * points * sizeof(Vec3));
  DynamicsState larger = saved;
  larger.motion.followed.resize(points);
  larger.settings.tools.push_back(makeBall());
  EXPECT_EQ(larger.bytes() - saved.bytes(), points * sizeof(Vec3) + sizeof(tool::ToolParams) + sizeof(tool::WaypointParams));
}

}  // namespace
}  // namespace deformable_surface::test
