// A model from outside the package, added by one line: scenes name it, and all functions of a simulation work.
#include "deformable_surface/base/value.h"
#include "deformable_surface/simulation/expectations.h"

#include <gtest/gtest.h>

#include <cmath>

#include "clouds.h"
#include "tethered_points/kind.h"

namespace deformable_surface::test {
namespace {

using simulation::Simulation;

const TetheredPointsKind kKind;
const bool kIsRegistered = (simulation::registerModel(kKind), true);

constexpr double kYoung = 2e4;    // Pa
constexpr double kDamping = 9.0;  // 1/s, next to critical

simulation::SceneParams tethered() {
  simulation::SceneParams p = hangingSheet();
  p.model = "tethered_points";
  p.material.young_modulus = kYoung;
  return p;
}

void run(Simulation& s, int steps) {
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
  }
}

TEST(OwnModel, IsNamedByScenesThatItsRulesAccept) {
  ASSERT_TRUE(kIsRegistered);
  simulation::SceneParams p;
  const Value scene = Value::Map{{"model", "tethered_points"}};
  EXPECT_TRUE(readParams(scene, p).empty());
  EXPECT_EQ(p.model, "tethered_points");
  EXPECT_TRUE(checkParams(tethered()).empty());

  simulation::SceneParams stiff = tethered();
  stiff.material.young_modulus = 1e9;
  ASSERT_EQ(checkParams(stiff).size(), 1u);
  EXPECT_EQ(checkParams(stiff)[0], "material.young_modulus: found one that no tether has; accepted: up to 1.0e+07");
}

TEST(OwnModel, IsRefusedWhatItDoesNotHave) {
  simulation::SceneParams p = tethered();
  p.pressure = 10.0;
  p.accuracy.position_error = 1e-3;
  p.accuracy.remember = false;
  p.pins[0].orientation = true;
  std::string all;
  for (const std::string& problem : checkParams(p)) all += problem + "\n";
  EXPECT_NE(all.find("pressure: found one, but the points of tethered_points have no sides"), std::string::npos) << all;
  EXPECT_NE(all.find("accuracy.position_error: found a target, but only mass_spring"), std::string::npos) << all;
  EXPECT_NE(all.find("pins[0].orientation: found true, but only oriented_particles"), std::string::npos) << all;

  Simulation s(tethered(), sheetCloud(10));
  tool::ToolParams knife;
  knife.id = "knife";
  knife.mode = tool::Mode::kCut;
  knife.path = {{0.0, Vec3::Zero(), Vec4(0.0, 0.0, 0.0, 1.0)}};
  EXPECT_THROW(s.setTool(knife), InputError);
  EXPECT_THROW(s.editParticles({}), InputError);
  EXPECT_THROW(s.setMaterial(nullptr, {}), InputError);
}

TEST(OwnModel, SagsByItsWeightOverItsStiffnessWherePinsDoNotHoldIt) {
  simulation::SceneParams p = tethered();
  p.material.damping = kDamping;
  Simulation s(p, sheetCloud(10));
  run(s, 300);
  const double sag = p.material.density * 9.81 / kYoung;
  for (Index i = 0; i < s.state().size(); ++i)
    EXPECT_NEAR(s.state().positions[i].z(), s.pinned()[i] ? 0.0 : -sag, 1e-3 * sag) << i;
  EXPECT_NEAR(simulation::computeQuantity("max_displacement", s), sag, 1e-3 * sag);
  EXPECT_EQ(s.surface(true).normals.size(), 100u);
}

TEST(OwnModel, ImplicitAndStaticStepsUseItsStiffness) {
  for (const auto type : {solve::IntegratorType::kImplicit, solve::IntegratorType::kStatic}) {
    simulation::SceneParams p = tethered();
    p.material.damping = kDamping;
    p.integrator.type = type;
    Simulation s(p, sheetCloud(10));
    run(s, type == solve::IntegratorType::kStatic ? 1 : 300);
    const double sag = p.material.density * 9.81 / kYoung;
    EXPECT_NEAR(s.surface(false).positions.back().z(), -sag, 1e-2 * sag);
  }
}

TEST(OwnModel, ResetsForksAndSnapshotsGoOnBitForBit) {
  Simulation s(tethered(), sheetCloud(10));
  run(s, 10);
  const simulation::Snapshot middle = s.snapshot();
  Simulation fork = s.fork();
  run(s, 10);
  const std::uint64_t end = s.stateHash();
  run(fork, 10);
  EXPECT_EQ(fork.stateHash(), end);
  s.restore(middle);
  run(s, 10);
  EXPECT_EQ(s.stateHash(), end);
  s.reset();
  run(s, 20);
  EXPECT_EQ(s.stateHash(), end);
  Simulation viewer = s.viewer();
  viewer.restore(s.sight());
  EXPECT_EQ(viewer.surface(false).positions, s.surface(false).positions);
}

TEST(OwnModel, IsPushedByToolsAndSleepsAtRest) {
  simulation::SceneParams p = tethered();
  p.gravity.setZero();
  Simulation s(p, sheetCloud(10));
  run(s, 2);
  EXPECT_TRUE(s.isAsleep());
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.kind = geometry::Solid::Kind::kSphere;
  ball.shape.radius = 0.2;
  ball.path = {{0.0, Vec3(0.6, 0.5, 0.5), Vec4(0.0, 0.0, 0.0, 1.0)}, {0.5, Vec3(0.6, 0.5, 0.1), Vec4(0.0, 0.0, 0.0, 1.0)}};
  s.setTool(ball);
  run(s, 80);
  // Contact is as soft as the tethers.
  EXPECT_LT(simulation::computeQuantity("min_z", s), -0.01);
}

}  // namespace
}  // namespace deformable_surface::test
