// Equilibria of what only tools hold: refused where it slides away on them, found where they hold it.
#include "../../src/simulation/carried_away.h"

#include "clouds.h"

#include <gtest/gtest.h>

#include <string>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

// A plane through (0, 0, height), turned about y.
tool::ToolParams planeAt(double height, double angle) {
  tool::ToolParams plane;
  plane.id = "plane at " + std::to_string(angle);
  plane.shape.kind = geometry::Solid::Kind::kPlane;
  plane.path.resize(1);
  plane.path[0].position = Vec3(0.0, 0.0, height);
  plane.path[0].orientation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitY())).coeffs();
  return plane;
}

SceneParams freeSheet(const std::vector<tool::ToolParams>& tools) {
  SceneParams p = hangingSheet();
  p.pins.clear();
  p.accuracy.estimate = false;
  p.integrator.type = solve::IntegratorType::kStatic;
  p.integrator.time_step = 0.25;
  p.tools = tools;
  return p;
}

TEST(CarriedAway, ASheetThatSlidesDownAPlaneHasNoEquilibrium) {
  for (const double angle : {1e-3, 0.3, 1.2}) {
    Simulation s(freeSheet({planeAt(-1.0, angle)}), sheetCloud(8));
    const Points before = s.state().positions;
    const simulation::StepOutcome outcome = s.step();
    EXPECT_FALSE(outcome.ok) << angle;
    EXPECT_NE(outcome.problem.find("along them or past them, since static steps have no friction"), std::string::npos)
        << angle << ": " << outcome.problem;
    EXPECT_EQ(s.state().positions, before);
  }
}

TEST(CarriedAway, WhatTheyHoldIsFoundFarAway) {
  // A floor that is a hundred times as far away as the sheet is wide, and a groove.
  for (const auto& tools : {std::vector<tool::ToolParams>{planeAt(-100.0, 0.0)}, {planeAt(-1.0, 0.3), planeAt(-1.0, -0.3)}}) {
    Simulation s(freeSheet(tools), sheetCloud(8));
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
  }
}

TEST(CarriedAway, APinnedSheetDoesNotCountThoughItStretchesFar) {
  tool::ToolParams beside;
  beside.id = "ball";
  beside.shape.radius = 0.1;
  beside.path = {{0.0, Vec3(-1.0, 0.5, 0.0)}};
  SceneParams p = freeSheet({beside});
  p.pins = hangingSheet().pins;
  p.material.young_modulus = 50.0;
  Simulation s(p, sheetCloud(8));
  const Points before = s.state().positions;
  const simulation::StepOutcome outcome = s.step();
  EXPECT_TRUE(outcome.ok) << outcome.problem;
  double moved = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) moved = std::max(moved, (s.state().positions[i] - before[i]).norm());
  EXPECT_GT(moved, 40.0);
}

}  // namespace
}  // namespace deformable_surface::test
