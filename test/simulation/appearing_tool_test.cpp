// A tool that appears where the surface already is: what it overlaps is pushed out little by little, and the surface lives.
#include "clouds.h"
#include "support/meshes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using simulation::Simulation;

constexpr double kRadius = 0.15;  // m, of the hollow ball

/// A hollow ball of soft foam that stands on its foot, without weight.
simulation::SceneParams foamBall() {
  simulation::SceneParams p;
  p.material.young_modulus = 2e5;
  p.material.thickness = 0.006;
  p.material.density = 400.0;
  p.material.damping = 4.0;
  p.gravity.setZero();
  p.simplification.target_points = 300;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(1.0, 1.0, -0.12);
  p.pins = {pin};
  return p;
}

cloud::PointCloud ballCloud() {
  return asCloud(makeSphere(2000, kRadius).points);
}

/// Two thirds of its radius deep in the top of the ball.
tool::ToolParams ball() {
  tool::ToolParams tool;
  tool.id = "ball";
  tool.shape.radius = 0.1;
  tool.path = {{0.0, Vec3(0.0, 0.0, 0.18)}};
  return tool;
}

double findDeepest(const Simulation& s, double height = 0.18) {
  double deepest = 0.0;
  for (const Vec3& x : s.state().positions) deepest = std::max(deepest, 0.1 - (x - Vec3(0.0, 0.0, height)).norm());
  return deepest;
}

/// Takes the step and returns its notice.
std::string takeStep(Simulation& s) {
  const simulation::StepOutcome outcome = s.step();
  EXPECT_TRUE(outcome.ok) << outcome.problem;
  return outcome.notice;
}

// At once the first step would throw points away at some 50 m/s, and what crumples then needs a thousand sub-steps.
TEST(AppearingTool, PushesOutWhatItOverlapsWithinATenthOfASecond) {
  for (const auto type : {solve::IntegratorType::kAuto, solve::IntegratorType::kImplicit}) {
    simulation::SceneParams p = foamBall();
    p.integrator.type = type;
    Simulation s(p, ballCloud());
    run(s, 2);
    s.setTool(ball());
    const double depth = findDeepest(s);
    EXPECT_GT(depth, 0.06);
    double fastest = 0.0, largest = 0.0;
    std::uint32_t substeps = 0;
    for (int k = 0; k < 12; ++k) {
      const std::string notice = takeStep(s);
      EXPECT_EQ(notice.find("tool 'ball' appears where ") != std::string::npos, k == 0) << k << ": " << notice;
      fastest = std::max(fastest, s.statistics().max_speed);
      largest = std::max(largest, s.statistics().max_stretch);
      substeps = std::max(substeps, s.statistics().substeps);
    }
    EXPECT_LT(fastest, 5.0);
    EXPECT_LT(largest, 0.5);
    EXPECT_LT(substeps, 60u);
    EXPECT_LT(findDeepest(s), 0.03 * depth);  // what presses back still bears on the penalty
    EXPECT_GT(s.toolReactions()[0].contacts, 0);
    s.removeTool("ball");
    const double stored = s.statistics().elastic_energy;
    run(s, 200);
    // A dent may stay, which shells have equilibria with.
    EXPECT_LT(s.statistics().elastic_energy, 0.6 * stored);
    EXPECT_LT(s.statistics().max_speed, 0.1);
    EXPECT_LT(s.statistics().substeps, 60u);
  }
}

TEST(AppearingTool, OneThatOnlyJustTouchesIsNotToldOfAndOneThatMovesIsNotNew) {
  Simulation s(foamBall(), ballCloud());
  tool::ToolParams tool = ball();
  tool.path[0].position.z() = kRadius + 0.1 - 1e-5;
  s.setTool(tool);
  EXPECT_EQ(takeStep(s), "");
  tool.path = {{s.time(), tool.path[0].position}, {s.time() + 0.1, Vec3(0.0, 0.0, 0.2)}};
  s.setTool(tool);
  for (int k = 0; k < 20; ++k) EXPECT_EQ(takeStep(s).find("appears"), std::string::npos);
  EXPECT_LT(findDeepest(s, 0.2), 1e-3);
  // Another shape is another tool.
  tool.shape.radius = 0.13;
  s.setTool(tool);
  EXPECT_NE(takeStep(s).find("tool 'ball' appears where "), std::string::npos);
}

TEST(AppearingTool, AMeshThatCameAgainIsTheSame) {
  const Mesh mesh = makeBoxMesh(Vec3(0.1, 0.1, 0.1));
  tool::ToolParams tool = ball();
  tool.path[0].position.z() = kRadius;
  tool.shape.kind = geometry::Solid::Kind::kMesh;
  Simulation s(foamBall(), ballCloud());
  for (int k = 0; k < 3; ++k) {
    ASSERT_EQ(geometry::setMesh(mesh.vertices, geometry::toRows(mesh.triangles), tool.shape), "");
    s.setTool(tool);
    EXPECT_EQ(takeStep(s).find("appears") != std::string::npos, k == 0) << k;
  }
}

TEST(AppearingTool, ForcesAreMinusTheGradientOfThePotentialWhileItEasesIn) {
  const std::vector<double> masses(3, 0.2);
  model::State state;
  state.positions = {Vec3(0.05, 0.02, 0.0), Vec3(-0.07, 0.0, 0.03), Vec3(0.3, 0.0, 0.0)};
  state.velocities.assign(3, Vec3::Zero());
  tool::ToolParams tool = ball();
  tool.path[0].position.setZero();
  simulation::ContactLoad load(masses);
  load.setRate(50.0);
  load.setTools({tool});
  EXPECT_TRUE(load.beginStep(1.0, 0.01, state, std::vector<char>(3, 0)));
  const auto forcesAt = [&](double time) {
    Points forces(3, Vec3::Zero());
    load.addForces(time, state, forces);
    return forces;
  };
  EXPECT_EQ(forcesAt(1.0)[0], Vec3::Zero());
  const Points half = forcesAt(1.05), whole = forcesAt(1.1);
  EXPECT_NEAR(half[0].norm(), 0.5 * whole[0].norm(), 1e-9);
  EXPECT_NEAR(whole[0].norm(), 0.2 * 2500.0 * (0.1 - state.positions[0].norm()), 1e-9);
  EXPECT_EQ(forcesAt(2.0)[0], whole[0]);
  EXPECT_EQ(whole[2], Vec3::Zero());
  for (int c = 0; c < 3; ++c) {
    model::State above = state, below = state;
    above.positions[1][c] += 1e-6;
    below.positions[1][c] -= 1e-6;
    EXPECT_NEAR(half[1][c], (load.potential(1.05, below) - load.potential(1.05, above)) / 2e-6, 1e-6);
  }
  // What easing in does to points that stay is its work.
  EXPECT_NEAR(load.estimateWork(1.0, 1.1, state, state), load.potential(1.1, state), 1e-12);
}

TEST(AppearingTool, EquilibriaHaveAllOfItAtOnce) {
  simulation::SceneParams p = foamBall();
  p.integrator.type = solve::IntegratorType::kStatic;
  p.integrator.max_iterations = 300;
  p.tools = {ball()};
  p.tools[0].path[0].position.z() = 0.23;
  Simulation s(p, ballCloud());
  takeStep(s);
  EXPECT_LT(findDeepest(s, 0.23), 1e-3);
  EXPECT_GT(s.toolReactions()[0].force.z(), 0.0);
}

TEST(AppearingTool, ASnapshotTakenWhileItEasesInGoesOnBitForBit) {
  simulation::SceneParams p = foamBall();
  p.tools = {ball()};
  Simulation s(p, ballCloud());
  run(s, 4);
  const simulation::Snapshot snapshot = s.snapshot();
  run(s, 20);
  const std::uint64_t hash = s.stateHash();
  s.restore(snapshot);
  run(s, 20);
  EXPECT_EQ(s.stateHash(), hash);
  s.reset();
  run(s, 24);
  EXPECT_EQ(s.stateHash(), hash);
}

}  // namespace
}  // namespace deformable_surface::test
