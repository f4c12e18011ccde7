#include "deformable_surface/simulation/contact_damping.h"
#include "clouds.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

tool::ToolParams makeTable(double friction, const Vec3& velocity = Vec3::Zero()) {
  tool::ToolParams tool;
  tool.id = "table";
  tool.shape.kind = geometry::Solid::Kind::kPlane;
  tool.friction = friction;
  tool.path = {{0.0, Vec3::Zero(), Vec4(0.0, 0.0, 0.0, 1.0)}, {1.0, velocity, Vec4(0.0, 0.0, 0.0, 1.0)}};
  return tool;
}

struct Touching {
  std::vector<double> masses{0.5};
  simulation::ContactLoad contact{masses};
  simulation::ContactDamping damping{contact};
  model::State state;

  Touching(const tool::ToolParams& tool, double height, double speed) {
    contact.setTools({tool});
    contact.setRate(100.0);
    state.positions = {Vec3(0.0, 0.0, height)};
    state.velocities = {Vec3(0.3, 0.0, speed)};
  }
  Vec3 force(double time = 0.0) const {
    Points forces(1, Vec3::Zero());
    damping.addForces(time, state, forces);
    return forces[0];
  }
};

TEST(ContactDamping, IsAShareOfCriticalAgainstTheVelocityAcrossTheTool) {
  const Touching in(makeTable(0.3), -1e-3, -0.01);
  const double coefficient = 2.0 * simulation::ContactDamping::kShare * 0.5 * 100.0;
  EXPECT_TRUE(in.force().isApprox(Vec3(0.0, 0.0, coefficient * 0.01), 1e-12));
  EXPECT_TRUE(Touching(makeTable(0.3), 1e-3, -0.01).force().isZero(0.0));  // does not touch
}

TEST(ContactDamping, NeverPulls) {
  const Touching out(makeTable(0.3), -1e-3, 10.0);
  EXPECT_DOUBLE_EQ(out.force().z(), -0.5 * 100.0 * 100.0 * 1e-3);
}

TEST(ContactDamping, SetsInWithTheSpringIfItIsGradual) {
  for (const double depth : {1e-9, 1e-3, 1e-2}) {
    const Touching in(makeTable(0.3), -depth, -1.0);
    const simulation::ContactDamping gradual(in.contact, true);
    Points forces(1, Vec3::Zero());
    gradual.addForces(0.0, in.state, forces);
    const double spring = 0.5 * 100.0 * 100.0 * depth;
    EXPECT_NEAR(forces[0].z(), std::min(spring, in.force().z()), 1e-9 * spring) << depth;
    EXPECT_GT(in.force().z(), 1.0);
  }
}

// On the way in, slowly and limited by the spring, and on the way out, where it cancels the spring.
TEST(ContactDamping, HasTheDerivativeOfItsForce) {
  constexpr double kStep = 0.01, kSmall = 1e-7;
  for (const auto& [speed, is_gradual] : {std::pair(-0.01, true), {-1.0, true}, {-1.0, false}, {10.0, true}, {10.0, false}}) {
    const auto findForce = [&, speed = speed, is_gradual = is_gradual](double moved) {
      const Touching there(makeTable(0.3), -1e-3 + moved, speed + moved / kStep);
      Points forces(1, Vec3::Zero());
      simulation::ContactDamping(there.contact, is_gradual).addForces(0.0, there.state, forces);
      return forces[0].z();
    };
    const Touching at(makeTable(0.3), -1e-3, speed);
    const simulation::ContactDamping damping(at.contact, is_gradual);
    BlockSparse matrix;
    matrix.begin(1);
    damping.addStiffness(0.0, at.state, kStep, matrix);
    damping.addIndefiniteStiffness(0.0, at.state, matrix);
    matrix.finish();
    const double slope = (findForce(kSmall) - findForce(-kSmall)) / (2.0 * kSmall);
    EXPECT_GT(std::abs(slope), 100.0);
    EXPECT_NEAR(matrix.values()[0](2, 2), -slope, 1e-4 * std::abs(slope)) << speed;
  }
}

TEST(ContactDamping, ContactWithoutFrictionHasNone) {
  const Touching in(makeTable(0.0), -1e-3, -0.01);
  EXPECT_TRUE(in.damping.isEmpty());
  EXPECT_TRUE(in.force().isZero(0.0));
}

// The work of a tool that approaches the point is bounded: no velocity of the point gives more power.
TEST(ContactDamping, EstimatesAtLeastTheWorkThatAMovingToolDoes) {
  const Vec3 velocity(0.0, 0.0, 0.2);
  for (const double speed : {-1.0, 0.0, 0.05, 0.1, 0.15, 0.3}) {
    const Touching t(makeTable(0.3, velocity), -1e-3, speed);
    const double power = t.force().z() * speed;
    EXPECT_LE(power, t.damping.estimateWork(0.0, 1e-6, t.state, t.state) / 1e-6 + 1e-12) << speed;
  }
}

// A spring with a fifth of critical damping that does not pull leaves 0.57 of the speed. A contact lasts only a few sub-steps.
TEST(ContactDamping, AboutHalfOfTheSpeedIsLeftAfterAnImpact) {
  const auto bounce = [](double friction) {
    simulation::SceneParams p = hangingSheet();
    p.pins.clear();
    p.material.damping = 0.0;
    p.gravity.setZero();
    p.integrator.time_step = 1e-3;
    tool::ToolParams table = makeTable(friction);
    table.path.resize(1);
    table.path[0].position = Vec3(0.0, 0.0, -0.005);
    p.tools = {table};
    simulation::Simulation s(p, sheetCloud());
    model::State falling = s.state();
    for (Vec3& v : falling.velocities) v = Vec3(0.0, 0.0, -0.5);
    s.setState(falling);
    run(s, 40);
    double mean = 0.0;
    for (const Vec3& v : s.state().velocities) mean += v.z() / s.state().size();
    return mean / 0.5;
  };
  EXPECT_NEAR(bounce(0.3), 0.5, 0.1);
  EXPECT_NEAR(bounce(0.0), 1.0, 0.01);
}

}  // namespace
}  // namespace deformable_surface::test
