// Inside one sheet the region around a poke is awake and the rest sleeps: with the loss of accuracy, for every number of threads,
// and through snapshots.
#include "../../src/simulation/self_contact_load.h"
#include "sleeping.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "../support/crossings.h"

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using simulation::Sleep;

constexpr Index kSide = 41;
constexpr Index kPoints = kSide * kSide;
constexpr double kTolerance = kSleepTolerance;

// A sheet in balance in which disturbances travel slowly, pinned along an edge. It is poked near a corner from the sixth step on.
SceneParams pokedSheet() {
  SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.material.young_modulus = 500.0;
  p.material.damping = 20.0;
  p.material.bending_rigidity = 1e-6;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.integrator.time_step = 2e-3;
  p.sleep.quiet_time = 0.05;
  p.sleep.tolerance = kTolerance;
  p.accuracy.estimate = false;
  p.forces.push_back({"poke", Vec3(0.85, 0.35, 0.0), Vec3(0.01, 0.0, 0.05), 0.04, 0.01, 0.03});
  return p;
}

cloud::PointCloud finePatch() { return sheetCloud(kSide); }

// A strip that is clamped along two rows and bends under its weight. near: m, of one more point from another; 0: none.
// A negative result: it was not found, and a notice says so.
double findSag(double near, double gravity, solve::IntegratorType type) {
  constexpr double kSpacing = 0.05;
  cloud::PointCloud cloud = asCloud(makeSheet(21, 6, 1.0, 0.25, 0.2).points);
  if (near > 0.0) cloud.positions.push_back(cloud.positions[60] + Vec3(near, 0.0, 0.0));
  SceneParams p = hangingSheet();
  p.pins[0].region.max.x() = 1.5 * kSpacing;
  p.material.young_modulus = 1e7;
  p.material.thickness = 0.01;
  p.material.bending_rigidity = {};
  p.gravity = Vec3(0.0, 0.0, -gravity);
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.integrator.type = type;
  p.integrator.time_step = 0.1;
  p.accuracy.estimate = false;
  Simulation s(p, cloud);
  if (!s.step().notice.empty()) return -1.0;
  double lowest = 0.0;
  for (const Vec3& x : s.state().positions) lowest = std::min(lowest, x.z());
  return -lowest;
}

// The stiffness between two points almost at one place must not pass for rounding of all forces.
TEST(SleepingParts, ALoadedSurfaceDoesNotBeginAsleepHoweverSmallTheLoad) {
  for (const double gravity : {1.0, 1e-2, 1e-4}) {
    const double sag = findSag(0.0, gravity, solve::IntegratorType::kStatic);
    EXPECT_GT(sag, 1e-3 * gravity) << gravity;
    EXPECT_NEAR(findSag(1e-5, gravity, solve::IntegratorType::kStatic), sag, 0.05 * sag) << gravity;
    EXPECT_GT(findSag(1e-5, gravity, solve::IntegratorType::kImplicit), 0.0) << gravity;
    const double nearer = findSag(1e-7, gravity, solve::IntegratorType::kStatic);
    EXPECT_TRUE(nearer < 0.0 || std::abs(nearer - sag) < 0.05 * sag) << gravity << ": " << nearer << ", not " << sag;
  }
}

TEST(SleepingParts, WhatIsAwakeTearsAsInASurfaceThatNeverSleeps) {
  for (const double step : {2e-3, 1e-2}) {
    SceneParams p = pokedSheet();
    p.forces[0] = {"pull", Vec3(0.85, 0.35, 0.0), Vec3(0.05, 0.0, 0.0), 0.04, 0.01, 0.03};
    p.mass_spring.tear_strain = 0.03;
    p.integrator.time_step = step;
    Simulation s(p, finePatch());
    p.sleep.mode = Sleep::kNever;
    Simulation never(p, finePatch());
    const std::size_t links = stretchLinksOf(s.model()).size();
    run(s, 1);
    EXPECT_EQ(s.statistics().awake, 0u);
    run(never, 1);
    bool was_partly_awake = false;
    for (double time = step; time < 0.06; time += step) {
      if (stretchLinksOf(s.model()).size() == links) was_partly_awake = was_partly_awake || isPartlyAwake(s);
      run(s, 1);
      run(never, 1);
    }
    EXPECT_TRUE(was_partly_awake || step > 5e-3);
    EXPECT_LT(stretchLinksOf(s.model()).size(), links);
    EXPECT_EQ(stretchLinksOf(s.model()), stretchLinksOf(never.model())) << step;
  }
}

TEST(SleepingParts, APokeMovesWhatItMovesAndTheRestSleepsWhereItIs) {
  SceneParams p = pokedSheet();
  Simulation s(p, finePatch());
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, finePatch());
  run(s, 5);
  run(never, 5);
  EXPECT_EQ(s.statistics().awake, 0u);
  std::uint32_t least = kPoints;
  double moved = 0.0;
  for (int k = 0; k < 25; ++k) {
    run(s, 1);
    run(never, 1);
    ASSERT_TRUE(isPartlyAwake(s)) << k;
    least = std::min(least, s.statistics().awake);
    const std::vector<std::string> skipped = s.statistics().skipped;
    EXPECT_EQ(std::count(skipped.begin(), skipped.end(), "sleeping"), 1);
    for (Index i = 0; i < kPoints; ++i)
      if (!s.isAwake(i)) {
        ASSERT_TRUE(s.state().velocities[i].isZero(0.0));
        ASSERT_LT((s.state().positions[i] - s.input().positions[i]).norm(), kTolerance);
      }
    moved = std::max(moved, largestDistance(never.state().positions, never.input().positions));
    EXPECT_LT(largestDistance(s.state().positions, never.state().positions), kTolerance) << k;
  }
  EXPECT_LT(least, 0.2 * kPoints);
  EXPECT_GT(moved, 1000.0 * kTolerance);
}

// With holes and points that coincide in the input, and without.
TEST(SleepingParts, TheSurfaceIsMadeAnewWhereThePokeIsAloneAndIsTheSameToTheBit) {
  for (const bool has_holes : {false, true}) {
    SceneParams p = pokedSheet();
    p.simplification.method = cloud::SimplificationMethod::kDelaunay;
    p.simplification.target_points = 800;
    cloud::PointCloud patch = sheetCloud(100);
    if (has_holes) {
      patch.positions[7].setConstant(std::numeric_limits<double>::quiet_NaN());
      patch.positions[5000] = patch.positions[4999];
    }
    Simulation s(p, patch), fresh(p, patch);
    const auto restsInTiles = [&] {
      const std::vector<std::string> skipped = s.statistics().skipped;
      return std::count(skipped.begin(), skipped.end(), "resting_tiles") == 1;
    };
    bool has_rested = false;
    s.surface(true);
    for (int k = 0; k < 20; ++k) {
      run(s, 1);
      const simulation::Surface& tiles = s.surface(true);
      has_rested = has_rested || (s.statistics().awake > 0 && restsInTiles());
      fresh.setState(s.state());
      fresh.surface(false);  // which discards the normals, so that all of it is computed in the next line
      const simulation::Surface& whole = fresh.surface(true);
      ASSERT_EQ(tiles.normals.size(), whole.normals.size());
      for (std::size_t i = 0; i < whole.positions.size(); ++i) {
        if (has_holes && i == 7) {
          ASSERT_TRUE(std::isnan(tiles.positions[i].x()));
          continue;
        }
        ASSERT_EQ(tiles.positions[i], whole.positions[i]) << k << " " << i;
        ASSERT_EQ(tiles.normals[i], whole.normals[i]) << k << " " << i;
        ASSERT_EQ(tiles.displacement[i], whole.displacement[i]) << k << " " << i;
      }
    }
    EXPECT_TRUE(has_rested);
    // If everything moves, everything is computed.
    s.setGravity(Vec3(0.0, 0.0, -9.81));
    run(s, 2);
    s.surface(true);
    EXPECT_FALSE(restsInTiles());
  }
}

// A patch flies down to a sheet that sleeps. Contact of the surface with itself must not be lost with the parts that sleep.
TEST(SleepingParts, WhatSleepsIsWokenByWhatComesToTouchIt) {
  SceneParams p = pokedSheet();
  p.forces = {{"push", Vec3(0.51, 0.513, 0.2), Vec3(0.0, 0.0, -1.2), 0.18, 0.01, 0.05}};
  p.material.thickness = 0.002;
  p.material.damping = 1.0;
  cloud::PointCloud cloud = finePatch();
  for (const Vec3& x : makeSheet(9, 9, 0.2, 0.2, 0.2).points) cloud.positions.push_back(x + Vec3(0.41, 0.413, 0.1));
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  for (const bool is_on : {true, false}) {
    p.contact.self = is_on;
    Simulation s(p, cloud);
    const std::vector<contact::Triangle> triangles =
        simulation::ContactSkin(s.state().positions, trianglesOf(s.model())).triangles;
    int in_parts = 0, crossed = 0;
    bool has_touched = false, sleeps_too_long = false;
    for (int k = 0; k < 150; ++k) {
      run(s, 1);
      if (k % 5 == 0) crossed += !findCrossings(s.state().positions, triangles).empty();
      if (!is_on) continue;
      has_touched = has_touched || s.statistics().self_contacts > 0;
      if (!has_touched) in_parts += isPartlyAwake(s);
      sleeps_too_long = sleeps_too_long || (s.statistics().self_contacts > 0 && isPartlyAwake(s));
    }
    EXPECT_EQ(crossed > 0, !is_on);
    if (!is_on) continue;
    EXPECT_GT(in_parts, 20);
    EXPECT_TRUE(has_touched);
    EXPECT_FALSE(sleeps_too_long);
  }
}

TEST(SleepingParts, WhatHasSettledSleepsAgainAndLiesWhereItWouldLie) {
  SceneParams p = pokedSheet();
  p.material.young_modulus = 2e4;
  p.material.damping = 5.0;
  p.integrator.time_step = 0.01;
  p.sleep.quiet_time = 0.2;
  p.sleep.tolerance = 10.0 * kTolerance;
  p.forces[0].force = Vec3(0.05, 0.02, 0.0);
  p.forces[0].end = 1e300;
  Simulation s(p, sheetCloud(21));
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, sheetCloud(21));
  int steps = 0;
  bool was_part = false;
  do {
    run(s, 1);
    ++steps;
    was_part = was_part || (s.statistics().awake > 0 && s.statistics().awake < 300);
  } while ((steps < 50 || s.statistics().awake > 0) && steps < 2000);
  EXPECT_TRUE(was_part);
  ASSERT_EQ(s.statistics().awake, 0u);
  run(never, steps + 500);
  EXPECT_LT(largestDistance(s.state().positions, never.state().positions), p.sleep.tolerance.value);
  EXPECT_GT(largestDistance(s.state().positions, s.input().positions), 1000.0 * kTolerance);
}

TEST(SleepingParts, AFrontThatComesFasterThanItsMarginIsNotHeldUp) {
  SceneParams p = pokedSheet();
  p.material.young_modulus = 1e5;
  p.integrator.time_step = 0.01;  // in which waves travel a tenth of a metre
  p.material.damping = 0.0;
  Simulation s(p, finePatch());
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, finePatch());
  bool was_part = false;
  for (int k = 0; k < 8; ++k) {
    run(s, 1);
    run(never, 1);
    was_part = was_part || isPartlyAwake(s);
    EXPECT_LT(largestDistance(s.state().positions, never.state().positions), 10.0 * kTolerance) << k;
  }
  EXPECT_TRUE(was_part);
  EXPECT_GT(s.statistics().awake, 0.9 * kPoints);
}

TEST(SleepingParts, APartIsBitIdenticalForOneTwoAndThreeThreadsAndThroughSnapshots) {
  expectSameBitsInParts(pokedSheet(), finePatch(), 12, 30);
}

TEST(SleepingParts, PressureDragAnchorsAndToolsActInAPartAsInTheWhole) {
  SceneParams p = pokedSheet();
  p.viscous_drag = 2.0;
  p.anchors.push_back({Vec3(0.8, 0.3, 0.0), Vec3(0.8, 0.3, 0.01), 0.5});
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.05;
  ball.friction = 0.3;
  ball.path.push_back({0.0, Vec3(0.85, 0.2, 0.051), Vec4(0.0, 0.0, 0.0, 1.0)});
  ball.path.push_back({0.05, Vec3(0.87, 0.2, 0.035), Vec4(0.0, 0.0, 0.0, 1.0)});
  p.tools.push_back(ball);
  Simulation s(p, finePatch());
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, finePatch());
  for (int k = 0; k < 25; ++k) {
    run(s, 1);
    run(never, 1);
    ASSERT_TRUE(isPartlyAwake(s)) << k;
    EXPECT_LT(largestDistance(s.state().positions, never.state().positions), 3.0 * kTolerance) << k;
  }
  EXPECT_GT(s.toolReactions()[0].contacts, 0);
  EXPECT_NEAR(s.toolReactions()[0].force.z(), never.toolReactions()[0].force.z(), 0.01 * never.toolReactions()[0].force.norm());
}

TEST(SleepingParts, AnImplicitStepOfAPartIsThatOfTheWhole) {
  SceneParams p = pokedSheet();
  p.integrator.type = solve::IntegratorType::kImplicit;
  p.integrator.tolerance = 1e-10;
  p.simplification.method = cloud::SimplificationMethod::kDelaunay;
  p.simplification.target_points = 600;
  p.material.damping = 200.0;
  Simulation s(p, finePatch());
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, finePatch());
  bool was_part = false;
  for (int k = 0; k < 8; ++k) {
    run(s, 1);
    run(never, 1);
    was_part = was_part || (s.statistics().awake > 0 && s.statistics().awake < 400);
    EXPECT_LT(largestDistance(s.state().positions, never.state().positions), 3.0 * kTolerance) << k;
  }
  EXPECT_TRUE(was_part);
}

TEST(SleepingParts, ADampingThatIsChangedWhileTheySleepActsOnWhatIsAwake) {
  SceneParams p = pokedSheet();
  Simulation s(p, finePatch());
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, finePatch());
  for (Simulation* one : {&s, &never}) {
    run(*one, 10);
    one->setDamping(200.0);
    run(*one, 40);  // parts sleep again
  }
  ASSERT_TRUE(isPartlyAwake(s));
  EXPECT_LT(largestDistance(s.state().positions, never.state().positions), kTolerance);
}

}  // namespace
}  // namespace deformable_surface::test
