// A tool that appears inside the surface: it arrives from the nearest free place, and the surface survives.
#include "clouds.h"
#include "deformable_surface/simulation/contact_load.h"
#include "support/meshes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using simulation::Simulation;

constexpr double kRadius = 0.15;  // m, of the hollow ball

/// A hollow ball of soft foam on its foot, without weight.
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

cloud::PointCloud ballCloud() { return asCloud(makeSphere(2000, kRadius).points); }

/// In the top of the ball, as deep as two thirds of its radius.
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

// At once, the first step would throw points away at some 50 m/s. The crumpled surface would then need a thousand sub-steps.
TEST(AppearingTool, ArrivesWithinATenthOfASecond) {
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
    Index most_contacts = 0;
    for (int k = 0; k < 12; ++k) {
      const std::string notice = takeStep(s);
      EXPECT_EQ(notice.find("tool 'ball' appears where ") != std::string::npos, k == 0) << k << ": " << notice;
      fastest = std::max(fastest, s.statistics().max_speed);
      largest = std::max(largest, s.statistics().max_stretch);
      substeps = std::max(substeps, s.statistics().substeps);
      most_contacts = std::max(most_contacts, s.toolReactions()[0].contacts);
    }
    EXPECT_LT(fastest, 5.0);
    EXPECT_LT(largest, 0.5);
    EXPECT_LT(substeps, 60u);
    EXPECT_LT(findDeepest(s), 0.03 * depth);  // the surface still presses on the penalty
    EXPECT_GT(most_contacts, 3);
    s.removeTool("ball");
    const double stored = s.statistics().elastic_energy;
    run(s, 200);
    // A dent may remain: shells have equilibria with dents.
    EXPECT_LT(s.statistics().elastic_energy, stored);
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
  // A tool with another shape is another tool.
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

TEST(AppearingTool, ComesFromTheNearestFreePlaceAndFollowsItsPathMeanwhile) {
  // A patch of points in the plane z = 0, except for one that is constrained. A ball with its centre a little above comes from
  // above.
  model::State state;
  for (int x = -5; x <= 5; ++x)
    for (int y = -5; y <= 5; ++y) state.positions.emplace_back(0.02 * x, 0.02 * y, 0.0);
  state.positions.emplace_back(0.0, 0.0, 0.2);
  state.velocities.assign(state.positions.size(), Vec3::Zero());
  std::vector<char> held(state.positions.size() - 1, 0);
  held.push_back(1);
  const std::vector<double> masses(held.size(), 0.2);
  tool::ToolParams tool = ball();
  tool.path = {{0.0, Vec3(0.0, 0.0, 0.03)}, {1.05, Vec3(0.0, 0.0, 0.03)}, {1.15, Vec3(0.1, 0.0, 0.03)}};
  simulation::ContactLoad load(masses);
  load.setRate(50.0);
  load.setTools({tool});
  EXPECT_TRUE(load.beginStep(1.0, 0.01, state, held));
  const auto placeAt = [&](double time) { return tool::interpolate(load.all()[0].tool.path, time).position; };
  EXPECT_TRUE(placeAt(1.0).isApprox(Vec3(0.0, 0.0, 0.1), 0.01)) << placeAt(1.0).transpose();
  EXPECT_TRUE(placeAt(1.05).isApprox(Vec3(0.0, 0.0, 0.065), 0.01)) << placeAt(1.05).transpose();
  EXPECT_TRUE(placeAt(1.1).isApprox(Vec3(0.05, 0.0, 0.03), 1e-9)) << placeAt(1.1).transpose();
  EXPECT_TRUE(placeAt(1.15).isApprox(Vec3(0.1, 0.0, 0.03), 1e-9)) << placeAt(1.15).transpose();
  // Another path during the arrival, as from messages.
  tool.path = {{1.05, Vec3(0.0, 0.1, 0.03)}};
  load.setTools({tool});
  EXPECT_TRUE(placeAt(1.05).isApprox(Vec3(0.0, 0.1, 0.065), 0.01)) << placeAt(1.05).transpose();
  EXPECT_TRUE(placeAt(1.2).isApprox(Vec3(0.0, 0.1, 0.03), 1e-9)) << placeAt(1.2).transpose();
}

TEST(AppearingTool, AHalfSpaceComesAlongItsNormal) {
  const std::vector<double> masses(2, 0.2);
  model::State state;
  state.positions = {Vec3(0.0, 0.0, -0.1), Vec3(0.3, 0.0, 0.5)};
  state.velocities.assign(2, Vec3::Zero());
  tool::ToolParams plane = ball();
  plane.shape.kind = geometry::Solid::Kind::kPlane;
  plane.path[0].position.setZero();
  simulation::ContactLoad load(masses);
  load.setRate(50.0);
  load.setTools({plane});
  const std::vector<char> held(2, 0);
  EXPECT_TRUE(load.beginStep(0.0, 0.01, state, held));
  EXPECT_NEAR(tool::interpolate(load.all()[0].tool.path, 0.0).position.z(), -0.1, 2e-3);
}

// Between the ears of a figure, or of any body with two sides, the shortest way out of each point would tear them apart.
TEST(AppearingTool, LeavesAThinSheetWhole) {
  simulation::SceneParams p = foamBall();
  p.pins[0].region.min = Vec3(-1.0, -1.0, -1.0);
  p.pins[0].region.max = Vec3(0.02, 1.0, 1.0);
  Simulation s(p, sheetCloud());
  tool::ToolParams tool = ball();
  for (const double z : {0.0, 0.01, -0.03}) {
    s.reset();
    tool.path = {{0.0, Vec3(0.6, 0.1, z)}};
    s.setTool(tool);
    double largest = 0.0, fastest = 0.0;
    for (int k = 0; k < 30; ++k) {
      takeStep(s);
      largest = std::max(largest, s.statistics().max_stretch);
      fastest = std::max(fastest, s.statistics().max_speed);
    }
    EXPECT_LT(largest, 0.5) << z;
    EXPECT_LT(fastest, 10.0) << z;
  }
}

TEST(AppearingTool, EquilibriaHaveAllOfItAtOnce) {
  simulation::SceneParams p = foamBall();
  p.integrator.type = solve::IntegratorType::kStatic;
  p.integrator.max_iterations = 300;
  p.tools = {ball()};
  p.tools[0].path[0].position.z() = 0.23;
  Simulation s(p, ballCloud());
  EXPECT_EQ(takeStep(s).find("appears"), std::string::npos);
  EXPECT_LT(findDeepest(s, 0.23), 1e-3);
  EXPECT_GT(s.toolReactions()[0].force.z(), 0.0);
}

// Otherwise each copy would choose a path of its own, and their difference would be no error.
TEST(AppearingTool, ArrivesAtCopiesAsItDoesAtWhatTheyAreCopiesOf) {
  const std::vector<double> masses(2, 0.2);
  const std::vector<char> held(2, 0);
  model::State fine, coarse;
  fine.positions = {Vec3(0.0, 0.0, 0.02), Vec3(0.01, 0.0, 0.02)};
  coarse.positions = {Vec3(0.02, 0.0, 0.0), Vec3(0.02, 0.01, 0.0)};
  fine.velocities = coarse.velocities = Points(2, Vec3::Zero());
  tool::ToolParams tool = ball();
  tool.path[0].position.setZero();
  simulation::ContactLoad load(masses), copy(masses), alone(masses);
  for (simulation::ContactLoad* l : {&load, &copy, &alone}) {
    l->setRate(50.0);
    l->setTools({tool});
  }
  const auto placeAt = [](const simulation::ContactLoad& l, double time) {
    return tool::interpolate(l.all()[0].tool.path, time).position;
  };
  load.beginStep(0.0, 0.01, fine, held);
  EXPECT_TRUE(load.hasNewArrival());
  copy.adoptArrivals(load);
  copy.beginStep(0.0, 0.01, coarse, held);
  EXPECT_FALSE(copy.hasNewArrival());
  alone.beginStep(0.0, 0.01, coarse, held);
  EXPECT_EQ(placeAt(copy, 0.05), placeAt(load, 0.05));
  EXPECT_GT((placeAt(alone, 0.05) - placeAt(load, 0.05)).norm(), 0.01);
  load.beginStep(0.01, 0.01, fine, held);
  EXPECT_FALSE(load.hasNewArrival());
}

// For every integrator, whatever times it evaluates within a step.
TEST(AppearingTool, ArrivesInTheFirstStepThatBeginsAtItsStartOrLater) {
  for (const auto type : {solve::IntegratorType::kAuto, solve::IntegratorType::kImplicit})
    for (const double start : {0.1, 0.105}) {
      simulation::SceneParams p = foamBall();
      p.integrator.type = type;
      p.tools = {ball()};
      p.tools[0].start = start;
      Simulation s(p, ballCloud());
      double fastest = 0.0;
      for (int k = 0; k < 24; ++k) {
        const bool is_first = k == (start > 0.1 ? 11 : 10);
        EXPECT_EQ(takeStep(s).find("tool 'ball' appears where ") != std::string::npos, is_first) << k << " " << start;
        fastest = std::max(fastest, s.statistics().max_speed);
        if (k < 10) {
          EXPECT_LT(fastest, 1e-9) << k << " " << start;
        }
      }
      EXPECT_LT(fastest, 5.0) << start;
    }
}

// It sleeps by then. The step in which the tool begins to act is checked at its end.
TEST(AppearingTool, WakesAnEquilibriumWhenItsTimeHasCome) {
  simulation::SceneParams p = foamBall();
  p.integrator.type = solve::IntegratorType::kStatic;
  p.integrator.max_iterations = 300;
  p.tools = {ball()};
  p.tools[0].path[0].position.z() = 0.23;
  for (const double start : {0.1, 0.07, 0.3}) {
    p.tools[0].start = start;
    Simulation s(p, ballCloud());
    run(s, 40);
    EXPECT_GT(s.toolReactions()[0].force.z(), 0.0) << start;
  }
}

TEST(AppearingTool, ASnapshotTakenWhileItArrivesGoesOnBitForBit) {
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
