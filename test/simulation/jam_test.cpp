// What a user is told of layers that are pressed together: where, by what, once at the beginning and once at the end.
#include "../../src/simulation/jam.h"
#include "../../src/simulation/dynamics.h"
#include "clouds.h"

#include <gtest/gtest.h>

#include <functional>

namespace deformable_surface::test {
namespace {

using simulation::Jam;
using simulation::SceneParams;
using simulation::Simulation;
using Type = solve::IntegratorType;

const Vec4 kStill(0.0, 0.0, 0.0, 1.0);
constexpr double kSpacing = 0.01, kGap = 0.02;
constexpr int kSide = 7;

cloud::PointCloud stackLayers(int layers) {
  cloud::PointCloud cloud;
  for (int layer = 0; layer < layers; ++layer)
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j)
        cloud.positions.emplace_back(kSpacing * (i + 0.3 * layer + 0.1 * ((i * 7 + j * 3) % 3)), kSpacing * j, kGap * layer);
  cloud.width = static_cast<Index>(cloud.positions.size());
  return cloud;
}

SceneParams stackScene(Type type) {
  SceneParams p;
  p.material.young_modulus = 3e5;
  p.material.thickness = 1e-3;
  p.material.density = 250.0;
  p.material.bending_rigidity = 1e-5;
  p.material.damping = 1.0;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.contact.self = true;
  p.contact.thickness = 0.004;
  p.gravity.setZero();
  p.integrator.type = type;
  p.integrator.time_step = 0.005;
  p.accuracy.estimate = false;
  return p;
}

// Two plates that close on three layers to far less than their thickness, then open.
SceneParams pressedByPlates(Type type) {
  SceneParams p = stackScene(type);
  const auto add = [&](const char* id, const std::vector<tool::WaypointParams>& path) {
    tool::ToolParams plate;
    plate.id = id;
    plate.shape.kind = geometry::Solid::Kind::kBox;
    plate.shape.size = Vec3(0.3, 0.3, 0.02);
    plate.path = path;
    p.tools.push_back(plate);
  };
  const Vec3 middle(0.03, 0.03, 0.0);
  add("lower", {{0.0, middle - 0.012 * Vec3::UnitZ(), kStill}});
  add("upper", {{0.0, middle + 0.055 * Vec3::UnitZ(), kStill},
                {0.3, middle + 0.010 * Vec3::UnitZ(), kStill},
                {0.5, middle + 0.3 * Vec3::UnitZ(), kStill}});
  return p;
}

// One layer is pinned, and the pins of the other press it through the first.
SceneParams pressedByPins(Type type) {
  SceneParams p = stackScene(type);
  p.pins.resize(2);
  p.pins[0].region.min = Vec3(-1.0, -1.0, -0.001);
  p.pins[0].region.max = Vec3(1.0, 1.0, 0.001);
  p.pins[1].region.min = Vec3(-1.0, -1.0, kGap - 0.001);
  p.pins[1].region.max = Vec3(1.0, 1.0, kGap + 0.001);
  p.pins[1].path = {{0.0, Vec3::Zero(), kStill}, {0.3, Vec3(0.0, 0.0, -0.03), kStill}, {0.5, Vec3(0.0, 0.0, 0.1), kStill}};
  return p;
}

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
    EXPECT_LE(told.lines.size(), 4u) << joinLines(told);
    ASSERT_FALSE(told.lines.empty());
    EXPECT_TRUE(has(told.lines[0], "contact limited the motion of ") && has(told.lines[0], "one of them at (")) << told.lines[0];
    EXPECT_TRUE(has(joinLines(told), "moving tool 'upper' ")) << joinLines(told);
    EXPECT_FALSE(has(joinLines(told), "pins")) << joinLines(told);
    EXPECT_FALSE(has(joinLines(told), "smaller time_step")) << joinLines(told);
    EXPECT_TRUE(has(told.at_end, "contact limited the motion of points in " + std::to_string(told.stopped) + " of "))
        << joinLines(told);
  }
}

TEST(Jam, PinsThatPressAreNamedOnceAndTheEndIsTold) {
  for (const Type type : {Type::kVerlet, Type::kImplicit}) {
    const Told told = runScene(pressedByPins(type), 2, 2.0);
    ASSERT_GT(told.stopped, 5);
    ASSERT_GE(told.lines.size(), 2u) << joinLines(told);
    EXPECT_LE(told.lines.size(), 4u) << joinLines(told);
    EXPECT_TRUE(has(told.lines[0], "resting pins[0] holds") && has(told.lines[0], "moving pins[1] holds")) << told.lines[0];
    EXPECT_TRUE(has(told.lines.back(), "contact limited the motion of points in " + std::to_string(told.stopped) + " of "))
        << joinLines(told);
    EXPECT_EQ(told.at_end, "");
  }
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
  for (int k = 1; k <= 4; ++k) jam.actors.push_back({"pins[" + std::to_string(k) + "]", Jam::Actor::Act::kHolds, false});
  EXPECT_TRUE(has(describeJam(jam), ", resting pins[2] holds and 2 more act")) << describeJam(jam);
}

}  // namespace
}  // namespace deformable_surface::test
