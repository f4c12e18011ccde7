// What is told of implicit steps in which a tool touches, where Verlet would be faster.
#include "clouds.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using solve::IntegratorType;

// How many notices of 60 steps in which a ball presses on a held sheet.
int countTold(IntegratorType type, double young_modulus, double away) {
  simulation::SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.material.young_modulus = young_modulus;
  p.integrator.type = type;
  p.integrator.max_substeps = 100000;
  p.accuracy.estimate = false;
  p.tools.emplace_back();
  p.tools[0].id = "ball";
  p.tools[0].shape.radius = 0.15;
  const Vec4 upright(0.0, 0.0, 0.0, 1.0);
  p.tools[0].path = {{0.0, Vec3(0.6, 0.0, 0.16 + away), upright}, {0.6, Vec3(0.6, 0.0, -0.1 + away), upright}};
  simulation::Simulation s(p, sheetCloud(20));
  int told = 0;
  for (int k = 0; k < 60; ++k) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
    told += outcome.notice.find("a tool touches, and steps of integrator.type implicit now take ") != std::string::npos;
  }
  return told;
}

TEST(CostlySteps, AreToldOnceWhereVerletWouldBeFaster) {
  EXPECT_EQ(countTold(IntegratorType::kImplicit, 1e5, 0.0), 1);
  EXPECT_EQ(countTold(IntegratorType::kVerlet, 1e5, 0.0), 0);
  EXPECT_EQ(countTold(IntegratorType::kAuto, 1e5, 0.0), 0);
}

TEST(CostlySteps, AreNotToldWithoutContactNorWhereVerletNeedsVeryManySubsteps) {
  EXPECT_EQ(countTold(IntegratorType::kImplicit, 1e5, 1.0), 0);
  EXPECT_EQ(countTold(IntegratorType::kImplicit, 1e11, 0.0), 0);
}

}  // namespace
}  // namespace deformable_surface::test
