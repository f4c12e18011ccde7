#include "../../src/simulation/estimated_dynamics.h"

#include "clouds.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using simulation::EstimatedDynamics;
namespace command = simulation::command;

EstimatedDynamics makeHanging(double gravity) {
  simulation::SceneParams params = hangingSheet();
  params.gravity = Vec3(0.0, 0.0, gravity);
  EstimatedDynamics sheet(params, simulation::buildRestSurface(params, sheetCloud(20), simulation::kCoarsestPoints));
  sheet.estimateError();
  return sheet;
}

double errorAfter(EstimatedDynamics& sheet, int steps) {
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(sheet.step().ok);
  return sheet.errorInRegions();
}

TEST(EstimatedDynamics, GivesItsCopiesTheCommandsThatItTakes) {
  EstimatedDynamics stated = makeHanging(-4.0), told = makeHanging(-1.0);
  told.apply(command::SetGravity{Vec3(0.0, 0.0, -4.0)});
  const double error = errorAfter(stated, 5);
  EXPECT_GT(error, 0.0);
  EXPECT_EQ(errorAfter(told, 5), error);
}

TEST(EstimatedDynamics, ForksWithItsEstimateUnlessItIsOnlyLookedAt) {
  EstimatedDynamics sheet = makeHanging(-4.0);
  errorAfter(sheet, 3);
  EstimatedDynamics fork(sheet, false);
  EXPECT_EQ(errorAfter(fork, 2), errorAfter(sheet, 2));
  EXPECT_EQ(EstimatedDynamics(sheet, true).estimator(), nullptr);
}

TEST(EstimatedDynamics, HasNoEstimateOfAStateThatCameWithoutOne) {
  EstimatedDynamics sheet = makeHanging(-4.0);
  sheet.restore(sheet.dynamics().save(), nullptr, false);
  EXPECT_TRUE(std::isinf(sheet.errorInRegions()));
  sheet.reset();
  EXPECT_TRUE(std::isfinite(errorAfter(sheet, 2)));
}

}  // namespace
}  // namespace deformable_surface::test
