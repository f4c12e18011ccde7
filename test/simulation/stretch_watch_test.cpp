// A surface that is pulled to more than twice its length is told, with what pulls; others are not.
#include "../../src/simulation/stretch_watch.h"
#include "../../src/simulation/dynamics.h"
#include "deformable_surface/simulation/simulation.h"

#include "deformable_surface/io/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::simulation {
namespace {

constexpr double kSize = 0.2;  // m
const Vec4 kStill(0.0, 0.0, 0.0, 1.0);

bool has(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

tool::ToolParams makeGrip(const std::string& id, double x, double pull, double time) {
  tool::ToolParams grip;
  grip.id = id;
  grip.mode = tool::Mode::kMove;
  grip.shape.radius = 0.025;
  grip.path = {{0.0, Vec3(x, 0, 0), kStill}, {time, Vec3(x + pull, 0, 0), kStill}};
  return grip;
}

// A sheet that two grips pull apart by this much, m, within 0.3 s.
SceneParams pulledSheet(double pull) {
  SceneParams p;
  p.simplification.target_points = 121;
  p.gravity = Vec3::Zero();
  p.accuracy.estimate = false;
  p.contact.self = false;
  p.integrator.time_step = 0.01;
  p.material.damping = 5.0;
  p.duration = 10.0;
  p.tools = {makeGrip("left", -0.5 * kSize, -0.5 * pull, 0.3), makeGrip("right", 0.5 * kSize, 0.5 * pull, 0.3)};
  return p;
}

Simulation makeSimulation(SceneParams p) {
  p.cloud.shape = CloudParams::Shape::kSheet;
  p.cloud.points = 121;
  p.cloud.size = Eigen::Vector2d(kSize, kSize);
  return {p, io::makeShape(p.cloud)};
}

std::string runFor(Simulation& s, int steps) {
  std::string told;
  for (int k = 0; k < steps; ++k) {
    const StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
    if (!outcome.notice.empty()) told += outcome.notice + "\n";
  }
  return told;
}

TEST(StretchWatch, GripsThatPullApartAreNamedOnceAndTheEndIsTold) {
  Simulation s = makeSimulation(pulledSheet(2.0 * kSize));
  const std::string told = runFor(s, 80);
  ASSERT_GT(s.statistics().max_stretch, StretchWatch::kMost);
  EXPECT_EQ(told.find("the surface is stretched by "), told.rfind("the surface is stretched by ")) << told;
  EXPECT_TRUE(has(told, "the surface is stretched by 1")) << told;
  EXPECT_TRUE(has(told, "tool 'left' and tool 'right' hold it there: they move apart by more than the surface can give way"))
      << told;
  EXPECT_TRUE(has(s.lastingNotices(), "the largest stretch was above 100 % in ")) << s.lastingNotices();
  s.reset();
  EXPECT_EQ(s.lastingNotices(), "");
}

TEST(StretchWatch, ItsEndIsTold) {
  SceneParams p = pulledSheet(2.0 * kSize);
  for (tool::ToolParams& grip : p.tools) grip.path.push_back({0.9, grip.path.front().position, kStill});
  Simulation s = makeSimulation(p);
  const std::string told = runFor(s, 250);
  EXPECT_TRUE(has(told, "the largest stretch was above 100 % in ") && has(told, "none in the last 1 s")) << told;
}

TEST(StretchWatch, AHalfOfTheLengthIsNotTold) {
  Simulation s = makeSimulation(pulledSheet(0.5 * kSize));
  const std::string told = runFor(s, 80) + s.lastingNotices();
  EXPECT_GT(s.statistics().max_stretch, 0.3);
  EXPECT_FALSE(has(told, "stretch")) << told;
}

TEST(StretchWatch, EquilibriaAreToldAtOnceAndPinsAreNamed) {
  SceneParams p = pulledSheet(0.0);
  p.integrator.type = solve::IntegratorType::kStatic;
  p.tools.clear();
  PinParams held, pulled;
  held.region.min = Vec3(-1, -1, -1);
  held.region.max = Vec3(-0.45 * kSize, 1, 1);
  pulled.region.min = Vec3(0.45 * kSize, -1, -1);
  pulled.region.max = Vec3(1, 1, 1);
  pulled.path = {{0.0, Vec3::Zero(), kStill}, {0.01, Vec3(2.0 * kSize, 0, 0), kStill}};
  p.pins = {held, pulled};
  Simulation s = makeSimulation(p);
  const std::string told = runFor(s, 1);
  EXPECT_TRUE(has(told, "pins[1] and pins[0] hold it there")) << told;
}

TEST(StretchWatch, ASnapshotAndAForkGoOnWithTheSameBits) {
  Simulation s = makeSimulation(pulledSheet(2.0 * kSize));
  runFor(s, 25);
  const Snapshot kept = s.snapshot();
  Simulation fork = s.fork();
  runFor(s, 40);
  const std::string told = runFor(fork, 40);
  EXPECT_EQ(fork.stateHash(), s.stateHash());
  EXPECT_TRUE(has(told, "the surface is stretched by ")) << told;
  const std::uint64_t hash = s.stateHash();
  s.restore(kept);
  EXPECT_TRUE(has(runFor(s, 40), "the surface is stretched by "));
  EXPECT_EQ(s.stateHash(), hash);
}

// The model and state of a simulation at rest: looks at it are what is tested.
TEST(StretchWatch, LooksAreFarApartAndTwoInARowMakeItLast) {
  Simulation s = makeSimulation(pulledSheet(0.0));
  model::State state = s.state();
  for (Vec3& p : state.positions) p *= 3.0;
  StretchWatch watch;
  EXPECT_FALSE(watch.endStep(s.model(), state, 10, false));
  EXPECT_EQ(watch.stretch(), 0.0);
  EXPECT_FALSE(watch.endStep(s.model(), state, 1000, false));
  EXPECT_NEAR(watch.stretch(), 2.0, 1e-12);
  EXPECT_TRUE(watch.endStep(s.model(), state, 1000, false));
  EXPECT_FALSE(watch.endStep(s.model(), s.state(), 1000, false));
  EXPECT_TRUE(watch.endStep(s.model(), state, 1, true));
}

TEST(StretchWatch, WhatActsThereIsListed) {
  Overstretch over;
  over.stretch = 2.4;
  over.place = Vec3(0.0, 0.5, 0.25);
  const std::string begin =
      "the surface is stretched by 240 % at (0, 0.5, 0.25) m: its material law is meant for small strains, and shape and forces "
      "there are not those of a material; ";
  EXPECT_EQ(describeOverstretch(over),
            begin + "no tool or pin acts there: loads or speeds are too large for its stiffness (statistics: max_stretch)");
  over.holders = {"pins[0]"};
  EXPECT_EQ(describeOverstretch(over),
            begin + "pins[0] holds it there: it moves by more than the surface can give way (statistics: max_stretch)");
  over.pushers = {"tool 'a'", "tool 'b'", "tool 'c'", "tool 'd'", "tool 'e'"};
  EXPECT_EQ(describeOverstretch(over),
            begin +
                "pins[0] holds it there and tool 'a', tool 'b', tool 'c', tool 'd' and 1 more touch it "
                "there: they move apart by more than the surface can give way (statistics: max_stretch)");
}

}  // namespace
}  // namespace deformable_surface::simulation
