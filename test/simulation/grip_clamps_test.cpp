// Tools that carry points clamp where their shape ends, as pins do, and turn the slope of the surface with them.
#include "../model/model_checks.h"
#include "sagging_strip.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

// A strip of 1.1 x 0.25 m, jittered, held by a box from x = 0 on.
constexpr double kEdge = 0.1, kLength = 1.0, kWidth = 0.25;
constexpr double kRigidity = 1.0, kSag = 1e-4;

Points makeStrip(Index along) {
  const Index extra = along / 10;
  return makeSheet(along + extra + 1, along / 4 + 1, kLength + kEdge, kWidth, 0.3).points;
}

SceneParams stiffStrip() {
  SceneParams p;
  p.accuracy.estimate = false;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.integrator.type = solve::IntegratorType::kStatic;
  p.integrator.tolerance = 1e-7;
  p.integrator.max_iterations = 200;
  p.material.young_modulus = 1e6;
  p.material.thickness = 0.01;
  p.material.density = 100.0;
  p.material.bending_rigidity = kRigidity;
  p.gravity = Vec3(0.0, 0.0, -8.0 * kRigidity * kSag / p.material.arealDensity());
  return p;
}

tool::ToolParams grip(double end) {
  tool::ToolParams tool;
  tool.id = "hand";
  tool.mode = tool::Mode::kMove;
  tool.shape.kind = geometry::Solid::Kind::kBox;
  tool.shape.size = Vec3(2.0, 2.0, 2.0);
  tool.path = {{0.0, Vec3(end - 1.0, 0.0, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)}};
  return tool;
}

simulation::PinParams pin(double end) {
  simulation::PinParams pin;
  pin.region.min = Vec3(end - 2.0, -1.0, -1.0);
  pin.region.max = Vec3(end, 1.0, 1.0);
  return pin;
}

TEST(GripClamps, ACantileverInAGripIsThatOfABeam) {
  double errors[2] = {};
  const Index along[] = {20, 40};
  for (int level = 0; level < 2; ++level)
    for (const double behind : {0.0, 0.48}) {
      const double end = kEdge + behind / along[level];
      SceneParams p = stiffStrip();
      p.tools = {grip(end)};
      Simulation s(p, asCloud(makeStrip(along[level])));
      const Points rest = s.state().positions;
      simulation::StepOutcome outcome = s.step();
      for (int k = 0; k < 4 && !outcome.has_converged; ++k) outcome = s.step();
      EXPECT_TRUE(outcome.ok && outcome.has_converged) << outcome.problem << outcome.notice;
      double tip = 0.0, row = 0.0;
      for (std::size_t i = 0; i < s.state().positions.size(); ++i)
        if (rest[i].x() > kLength + kEdge - 1e-9) {
          tip -= s.state().positions[i].z();
          ++row;
        }
      const double exact = kSag * std::pow((kLength + kEdge - end) / kLength, 4);
      errors[level] = std::max(errors[level], std::abs(tip / row / exact - 1.0));
    }
  EXPECT_LT(errors[0], 0.01);
  EXPECT_LT(errors[1], 0.003);
}

// For every integrator, along a path that lifts and turns.
TEST(GripClamps, AGripDoesWhatAPinOnItsPathDoes) {
  const double half = 0.25;
  const double end = 0.137;
  for (const auto type : {solve::IntegratorType::kVerlet, solve::IntegratorType::kImplicit, solve::IntegratorType::kStatic}) {
    SceneParams p = stiffStrip();
    p.integrator.type = type;
    p.material.young_modulus = 1e5;
    p.material.damping = 1.0;
    p.gravity = Vec3(0.0, 0.0, -1.0);
    SceneParams pinned = p;
    p.tools = {grip(end)};
    p.tools[0].path.push_back({0.2, Vec3(end - 1.0, 0.0, 0.05), Vec4(0.0, std::sin(half), 0.0, std::cos(half))});
    pinned.pins = {pin(end)};
    pinned.pins[0].path = p.tools[0].path;
    const Points strip = makeStrip(20);
    Simulation gripped(p, asCloud(strip)), reference(pinned, asCloud(strip));
    const Points rest = gripped.state().positions;
    run(gripped, 25);
    run(reference, 25);
    EXPECT_LT(findLargestDistance(gripped.state().positions, reference.state().positions), 1e-9) << static_cast<int>(type);
    EXPECT_GT(findLargestDistance(gripped.state().positions, rest), 0.05);
  }
}

TEST(GripClamps, LettingGoLeavesNothingOfTheClamp) {
  SceneParams p = stiffStrip();
  p.integrator.type = solve::IntegratorType::kVerlet;
  p.gravity.setZero();
  p.pins = {pin(kEdge)};
  const Points strip = makeStrip(20);
  Simulation s(p, asCloud(strip));
  const Points bent = perturb(s.state().positions, 1e-3);
  const auto energy = [&] { return s.model().elasticEnergy({bent, Points(bent.size(), Vec3::Zero())}); };
  run(s, 1);
  const double before = energy();
  tool::ToolParams hand = grip(0.0);
  hand.shape.size = Vec3(0.3, 2.0, 0.1);
  hand.path[0].position = Vec3(1.0, 0.0, 0.0);
  s.setTool(hand);
  run(s, 1);
  EXPECT_NE(energy(), before);
  s.removeTool("hand");
  run(s, 1);
  EXPECT_EQ(energy(), before);
}

TEST(GripClamps, AGripOnOneRowIsAHinge) {
  SceneParams p = stiffStrip();
  p.gravity.setZero();
  p.tools = {grip(1e-6)};
  const Points strip = makeStrip(20);
  Simulation s(p, asCloud(strip));
  const Points bent = perturb(s.state().positions, 1e-3);
  const double before = s.model().elasticEnergy({bent, Points(bent.size(), Vec3::Zero())});
  run(s, 1);
  EXPECT_EQ(s.model().elasticEnergy({bent, Points(bent.size(), Vec3::Zero())}), before);
}

TEST(GripClamps, ASnapshotHasThem) {
  SceneParams p = stiffStrip();
  p.integrator.type = solve::IntegratorType::kVerlet;
  p.gravity = Vec3(0.0, 0.0, -1.0);
  p.tools = {grip(0.137)};
  Simulation s(p, asCloud(makeStrip(20)));
  run(s, 3);
  Simulation fork = s.fork();
  run(s, 3);
  run(fork, 3);
  EXPECT_EQ(s.state().positions, fork.state().positions);
  s.reset();
  run(s, 6);
  EXPECT_EQ(s.state().positions, fork.state().positions);
}

}  // namespace
}  // namespace deformable_surface::test
