// What a user is told of layers that are pressed together: where, by what, once at the beginning and once at the end.
#include "../../src/simulation/jam.h"
#include "../../src/simulation/dynamics.h"
#include "pressed_layers.h"

#include <gtest/gtest.h>

#include <functional>

namespace deformable_surface::test {
namespace {

using simulation::Jam;
using simulation::SceneParams;
using simulation::Simulation;
using Type = solve::IntegratorType;

struct Told {
  std::vector<std::string> lines;
  std::string at_end;  // of the run
  int stopped = 0;     // steps in which points were stopped
};
Told runScene(const SceneParams& params, int layers, double duration) {
  Told told;
  Simulation s(params, stackLayers(layers));
  const int steps = static_cast<int>(std::lround(duration / params.integrator.time_step));
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
    if (!outcome.notice.empty()) told.lines.push_back(outcome.notice);
    told.stopped += s.statistics().stopped_points > 0;
  }
  told.at_end = s.lastingNotices();
  EXPECT_EQ(s.statistics().stopped_steps, static_cast<std::uint64_t>(told.stopped));
  return told;
}

std::string joinLines(const Told& told) {
  std::string all;
  for (const std::string& line : told.lines) all += line + "\n";
  return all + told.at_end;
}

bool has(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

TEST(Jam, PlatesThatCloseAreNamedAndPinsAreNot) {
  for (const Type type : {Type::kVerlet, Type::kImplicit}) {
    SceneParams p = pressedByPlates(type);
    const Told told = runScene(p, 3, 0.4);
    ASSERT_GE(told.stopped, 5);
    EXPECT_LE(told.lines.size(), type == Type::kVerlet ? 4u : 5u) << joinLines(told);  // implicit steps: also that they are many
    const auto limited = std::find_if(told.lines.begin(), told.lines.end(),
                                      [](const std::string& line) { return has(line, "contact limited the motion of "); });
    ASSERT_NE(limited, told.lines.end()) << joinLines(told);
    EXPECT_TRUE(has(*limited, "one of them at (")) << *limited;
    EXPECT_TRUE(has(joinLines(told), "moving tool 'upper' ")) << joinLines(told);
    EXPECT_FALSE(has(joinLines(told), "pins")) << joinLines(told);
    EXPECT_FALSE(has(joinLines(told), "smaller time_step")) << joinLines(told);
    EXPECT_TRUE(has(told.at_end, "contact limited the motion of points in " + std::to_string(told.stopped) + " of "))
        << joinLines(told);
  }
}

// Pins press the layers together, and a magnet above them reaches all of their points.
TEST(Jam, AToolThatAttractsPullsAndDoesNotPush) {
  SceneParams p = pressedByPins(Type::kVerlet);
  tool::ToolParams magnet;
  magnet.id = "magnet";
  magnet.mode = tool::Mode::kAttract;
  magnet.shape.radius = 0.01;
  magnet.strength = 1e-3;
  magnet.reach = 0.2;
  magnet.path = {{0.0, Vec3(0.03, 0.03, 0.06), kStill}};
  p.tools = {magnet};
  const Told told = runScene(p, 2, 0.3);
  ASSERT_GT(told.stopped, 5);
  EXPECT_TRUE(has(joinLines(told), "resting tool 'magnet' pulls")) << joinLines(told);
}

TEST(Jam, PinsThatPressAreNamedOnceAndTheEndIsTold) {
  for (const Type type : {Type::kVerlet, Type::kImplicit}) {
    const Told told = runScene(pressedByPins(type), 2, 2.0);
    ASSERT_GT(told.stopped, 5);
    ASSERT_GE(told.lines.size(), 2u) << joinLines(told);
    EXPECT_LE(told.lines.size(), 4u) << joinLines(told);
    EXPECT_TRUE(has(joinLines(told), "resting pins[0] holds") && has(joinLines(told), "moving pins[1] holds")) << joinLines(told);
    EXPECT_TRUE(has(told.lines.back(), "contact limited the motion of points in " + std::to_string(told.stopped) + " of "))
        << joinLines(told);
    EXPECT_EQ(told.at_end, "");
  }
}

// A patch of 3 by 3 points falls onto a layer, in the middle.
TEST(Jam, OfFewPointsNothingIsTold) {
  SceneParams p = stackScene(Type::kVerlet);
  p.pins.resize(1);
  p.pins[0].region.min = Vec3(-1.0, -1.0, -0.001);
  p.pins[0].region.max = Vec3(1.0, 1.0, 0.001);
  cloud::PointCloud cloud = stackLayers(1);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) cloud.positions.emplace_back(0.02 + kSpacing * i, 0.02 + kSpacing * j, kGap);
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  Simulation s(p, cloud);
  model::State state = s.state();
  for (Index i = 0; i < state.size(); ++i)
    if (state.positions[i].z() > 0.5 * kGap) state.velocities[i] = Vec3(0.0, 0.0, -8.0);
  s.setState(state);
  std::string told;
  for (int k = 0; k < 20; ++k) told += s.step().notice;
  EXPECT_GT(s.statistics().stopped_steps, 0u);
  EXPECT_EQ(told + s.lastingNotices(), "");
}

TEST(Jam, FewPointsThatContactHoldsBackFarFromTheirPathAreTold) {
  SceneParams p = pressedByPins(Type::kVerlet);
  p.pins[1].region.max = Vec3(0.016, 0.012, kGap + 0.001);
  Simulation s(p, stackLayers(2));
  std::string told;
  Index most = 0;
  for (int k = 0; k < 60; ++k) {
    told += s.step().notice;
    most = std::max(most, static_cast<Index>(s.statistics().stopped_points));
  }
  EXPECT_LT(most, 15);
  EXPECT_TRUE(has(told, "slower paths of what pushes and holds, and more room between, help")) << told << most;
  EXPECT_TRUE(has(told, "moving pins[1] holds")) << told;
}

TEST(Jam, AfterAResetItIsToldAgain) {
  const SceneParams p = pressedByPins(Type::kVerlet);
  Simulation s(p, stackLayers(2));
  std::string first, again;
  for (int k = 0; k < 60; ++k) first += s.step().notice;
  EXPECT_NE(s.lastingNotices(), "");
  Simulation fork = s.fork();
  EXPECT_EQ(fork.lastingNotices(), "");
  s.reset();
  EXPECT_EQ(s.lastingNotices(), "");
  for (int k = 0; k < 60; ++k) again += s.step().notice;
  EXPECT_NE(first, "");
  EXPECT_EQ(first, again);
}

TEST(Jam, TheSentenceNamesWhatIsNearElseWhatActsOnTheSamePartElseNothing) {
  Jam jam;
  jam.points = 12;
  jam.place = Vec3(0.0, 0.5, -0.25);
  const std::string where = "contact limited the motion of 12 points, one of them at (0, 0.5, -0.25) m, ";
  EXPECT_EQ(
      describeJam(jam),
      where + "where no tool or pin is near, nor acts on the same part: parts meet by their own motion, or under other loads");
  jam.actors = {{"tool 'a'", Jam::Actor::Act::kPushes, true}, {"pins[0]", Jam::Actor::Act::kHolds, false}};
  EXPECT_EQ(describeJam(jam),
            where +
                "where no tool or pin is near; on the same part of the surface, moving tool 'a' pushes and resting "
                "pins[0] holds");
  jam.are_near = true;
  jam.actors[0].act = Jam::Actor::Act::kIsNear;
  EXPECT_EQ(describeJam(jam), where + "where moving tool 'a' is near and resting pins[0] holds");
  jam.actors[0].act = Jam::Actor::Act::kPushes;
  EXPECT_EQ(describeJam(jam), where + "where moving tool 'a' pushes and resting pins[0] holds");
  jam.actors[0].act = Jam::Actor::Act::kPulls;
  EXPECT_EQ(describeJam(jam), where + "where moving tool 'a' pulls and resting pins[0] holds");
  jam.actors[0].act = Jam::Actor::Act::kHolds;
  EXPECT_EQ(
      describeJam(jam),
      where + "where moving tool 'a' holds and resting pins[0] holds; held points may lag behind the paths of what holds them");
  jam.actors[0].act = Jam::Actor::Act::kPushes;
  for (int k = 1; k <= 4; ++k) jam.actors.push_back({"pins[" + std::to_string(k) + "]", Jam::Actor::Act::kHolds, false});
  EXPECT_TRUE(has(describeJam(jam), ", resting pins[2] holds and 2 more act")) << describeJam(jam);
  // Far from the origin, points of a surface are still told apart.
  jam.place = Vec3(1000.03214, -700.5, 1e5);
  EXPECT_TRUE(has(describeJam(jam), "one of them at (1000.0321, -700.5, 100000) m, ")) << describeJam(jam);
}

}  // namespace
}  // namespace deformable_surface::test
