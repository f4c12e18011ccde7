// Points at rest are skipped. A surface falls asleep where it would rest without sleep, and wakes from every cause. Parts of a
// surface: sleeping_parts_test.cpp.
#include "clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using simulation::Sleep;
using solve::IntegratorType;

constexpr double kQuietTime = 0.2;
constexpr int kSoon = 2000;  // steps after which a damped sheet sleeps

double largestDistance(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

// A soft sheet that stretches under its weight and comes to rest in a few seconds.
SceneParams dampedSheet() {
  SceneParams p = hangingSheet();
  p.material.damping = 5.0;
  p.material.young_modulus = 2e4;
  p.gravity = Vec3(1.0, 0.0, 0.0);
  p.simplification.target_points = 120;
  p.sleep.quiet_time = kQuietTime;
  p.accuracy.estimate = false;
  return p;
}

SceneParams sheetInBalance() {
  SceneParams p = dampedSheet();
  p.gravity.setZero();
  return p;
}

bool isAsleep(const Simulation& s) { return s.statistics().awake == 0; }

// Steps until it sleeps; fails the test if it does not.
int runUntilAsleep(Simulation& s, int most = kSoon) {
  for (int k = 1; k <= most; ++k) {
    run(s, 1);
    if (isAsleep(s)) return k;
  }
  ADD_FAILURE() << "still awake";
  return most;
}

bool isSkipped(const Simulation& s, const char* what) {
  const std::vector<std::string> skipped = s.statistics().skipped;
  return std::count(skipped.begin(), skipped.end(), what) > 0;
}

TEST(Activity, ASurfaceInBalanceSleepsFromTheFirstStep) {
  SceneParams p = sheetInBalance();
  p.material.damping = 0.0;  // if it moved, it would not come to rest
  Simulation s(p, sheetCloud());
  EXPECT_FALSE(isAsleep(s));
  run(s, 3);
  EXPECT_TRUE(isAsleep(s));
  EXPECT_TRUE(isSkipped(s, "step"));
  EXPECT_EQ(s.statistics().substeps, 0u);
  EXPECT_NEAR(s.time(), 0.03, 1e-12);
  EXPECT_EQ(s.stepCount(), 3u);
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, sheetCloud());
  run(never, 3);
  EXPECT_FALSE(isAsleep(never));
  EXPECT_FALSE(isSkipped(never, "step"));
  EXPECT_LT(largestDistance(s.state().positions, never.state().positions), 1e-14);  // rounding of a metre
}

TEST(Activity, WhatACommandMeantIsSaidThoughAllFallAsleepInItsStep) {
  SceneParams p = sheetInBalance();
  p.forces.push_back({"pull", Vec3(0.0, 0.5, 0.0), Vec3(0.0, 0.0, 1.0)});  // where the sheet is pinned
  Simulation s(p, sheetCloud());
  const simulation::StepOutcome outcome = s.step();
  EXPECT_TRUE(isAsleep(s));
  EXPECT_NE(outcome.notice.find("it moves nothing"), std::string::npos) << outcome.notice;
}

TEST(Activity, ADampedSheetFallsAsleepWithinTheToleranceOfWhereItWouldLie) {
  SceneParams p = dampedSheet();
  Simulation s(p, sheetCloud());
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, sheetCloud());
  const double tolerance = 1e-4 * std::sqrt(1.0 / 120);  // the default
  const int steps = runUntilAsleep(s);
  const Points asleep = s.state().positions;
  run(s, 500);
  EXPECT_EQ(s.state().positions, asleep);
  EXPECT_EQ(s.statistics().kinetic_energy, 0.0);
  run(never, steps + 500);
  EXPECT_FALSE(isAsleep(never));
  EXPECT_LT(largestDistance(asleep, never.state().positions), tolerance);
  EXPECT_GT(largestDistance(asleep, never.state().positions), 0.0);
  EXPECT_GT(largestDistance(asleep, s.input().positions), 0.0);
}

TEST(Activity, UntilItSleepsEveryBitIsAsWithoutSleeping) {
  SceneParams p = dampedSheet();
  Simulation s(p, sheetCloud());
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, sheetCloud());
  int compared = 0;
  for (; compared < kSoon; ++compared) {
    run(s, 1);
    run(never, 1);
    if (s.statistics().awake != never.statistics().awake) break;
    ASSERT_EQ(s.stateHash(), never.stateHash()) << compared;
  }
  EXPECT_GT(compared, 50);
  EXPECT_LT(compared, kSoon);
}

TEST(Activity, WithoutDampingNothingThatMovesSleeps) {
  SceneParams p = dampedSheet();
  p.material.damping = 0.0;
  p.gravity *= 1e-7;  // slower than the motion that may be suppressed in any case
  Simulation s(p, sheetCloud());
  for (int k = 0; k < 100; ++k) {
    run(s, 1);
    EXPECT_GT(s.statistics().awake, 100u) << k;
  }
}

TEST(Activity, ASwingsTurningPointIsNoRest) {
  SceneParams p = dampedSheet();
  p.material.damping = 0.02;
  p.sleep.quiet_time = 0.02;  // shorter than the time a sheet spends at its turning point
  Simulation s(p, sheetCloud());
  for (int k = 0; k < 300; ++k) {
    run(s, 1);
    EXPECT_GT(s.statistics().awake, 100u) << k;
  }
}

TEST(Activity, AUniformDriftIsNoRest) {
  SceneParams p = sheetInBalance();
  p.pins.clear();
  p.material.damping = 0.0;
  p.material.spring_damping = 1e-4;  // dissipates, but does not stop a rigid motion
  Simulation s(p, sheetCloud());
  model::State state = s.state();
  for (Vec3& v : state.velocities) v = Vec3(0.0, 0.0, 1e-6);
  s.setState(state);
  run(s, 200);
  EXPECT_GT(s.statistics().awake, 100u);
  EXPECT_NEAR(s.state().positions[0].z() - state.positions[0].z(), 2e-6, 1e-9);
}

struct Cause {
  const char* name;
  std::function<void(Simulation&)> act;
};

tool::ToolParams ballAt(const Vec3& place) {
  tool::ToolParams tool;
  tool.id = "ball";
  tool.shape.radius = 0.1;
  tool.path.resize(1);
  tool.path[0].position = place;
  return tool;
}

const geometry::Region kCorner{geometry::Region::Kind::kSphere, {}, {}, Vec3(1.0, 0.5, 0.0), 0.3};

const Cause kCauses[] = {
    {"Force",
     [](Simulation& s) {
       s.setForce({"pull", Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.1), 0.1, 0.0, 1e300});
     }},
    {"Gravity", [](Simulation& s) { s.setGravity(Vec3(0.0, 0.0, -1.0)); }},
    {"Pin", [](Simulation& s) { EXPECT_GT(s.pin(kCorner), 0); }},
    {"GivenState",
     [](Simulation& s) {
       model::State state = s.state();
       state.positions.back().z() += 0.01;
       s.setState(state);
     }},
    {"Tool", [](Simulation& s) { s.setTool(ballAt(Vec3(1.0, 0.0, 0.05))); }},
    {"Grip",
     [](Simulation& s) {
       tool::ToolParams tool = ballAt(Vec3(1.0, 0.0, 0.0));
       tool.mode = tool::Mode::kMove;
       tool.path.push_back({s.time() + 1.0, Vec3(1.0, 0.0, 0.5), Vec4(0.0, 0.0, 0.0, 1.0)});
       tool.path.front().time = s.time();
       s.setTool(tool);
     }},
};

class ActivityCauses : public testing::TestWithParam<Cause> {};

TEST_P(ActivityCauses, WakesWhatSleeps) {
  Simulation s(sheetInBalance(), sheetCloud());
  run(s, 2);
  ASSERT_TRUE(isAsleep(s));
  const std::uint64_t before = s.stateHash();
  GetParam().act(s);
  run(s, 2);
  EXPECT_FALSE(isAsleep(s));
  if (std::string(GetParam().name) != "Pin") {
    EXPECT_NE(s.stateHash(), before);
  }
}

INSTANTIATE_TEST_SUITE_P(, ActivityCauses, testing::ValuesIn(kCauses),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(Activity, ForcesThatEndOrAreTakenAwayAndPinsThatGoWake) {
  SceneParams p = sheetInBalance();
  p.forces.push_back({"ends", Vec3(1.0, 0.3, 0.0), Vec3(0.2, 0.0, 0.0), 0.2, 0.5, 16.0});
  Simulation s(p, sheetCloud());
  run(s, 49);
  EXPECT_TRUE(isAsleep(s));
  EXPECT_FALSE(s.isLeftAlone()) << "the force will wake it by itself";
  run(s, 2);
  EXPECT_FALSE(isAsleep(s)) << "a force of the scene has begun";
  runUntilAsleep(s, 1500);
  run(s, 1602 - static_cast<int>(s.stepCount()));
  EXPECT_FALSE(isAsleep(s)) << "and ended";
  s.setForce({"pull", Vec3(1.0, 0.0, 0.0), Vec3(0.2, 0.0, 0.0), 0.2, 0.0, 1e300});
  runUntilAsleep(s);
  s.removeForce("pull");
  run(s, 1);
  EXPECT_FALSE(isAsleep(s)) << "one is taken away";
  runUntilAsleep(s);
  EXPECT_GT(s.unpin({geometry::Region::Kind::kBox, Vec3::Constant(-1.0), Vec3(0.01, 1.0, 1.0), Vec3::Zero(), 0.0}), 0);
  run(s, 1);
  EXPECT_FALSE(isAsleep(s)) << "pins are gone";
}

TEST(Activity, AToolWakesWhatItComesNearNotWhatItPassesFarAway) {
  SceneParams p = sheetInBalance();
  p.pins.push_back(p.pins[0]);  // along the opposite edge, too: it cannot swing out of the way
  p.pins[1].region.min.x() += 1.0;
  p.pins[1].region.max.x() += 1.0;
  p.material.bending_rigidity = 0.1;  // the free edges follow within seconds
  Simulation s(p, sheetCloud());
  run(s, 1);
  ASSERT_TRUE(isAsleep(s));
  EXPECT_TRUE(s.isLeftAlone());
  tool::ToolParams ball = ballAt(Vec3(0.5, 0.0, 1.0));
  ball.path.push_back({1.0, Vec3(0.5, 0.0, 0.5), Vec4(0.0, 0.0, 0.0, 1.0)});
  ball.path.push_back({1.5, Vec3(0.5, 0.0, 0.05), Vec4(0.0, 0.0, 0.0, 1.0)});
  s.setTool(ball);
  run(s, 100);
  EXPECT_TRUE(isAsleep(s));
  EXPECT_FALSE(s.isLeftAlone());
  run(s, 50);
  EXPECT_FALSE(isAsleep(s));
  EXPECT_GT(s.toolReactions()[0].contacts, 0);
  // At rest on the tool it sleeps, too. It wakes when the tool is removed.
  runUntilAsleep(s, 2000);
  EXPECT_GT(s.toolReactions()[0].contacts, 0);
  s.moveTool("ball", {{0.0, Vec3(0.5, 0.0, 1.0), Vec4(0.0, 0.0, 0.0, 1.0)}});
  run(s, 1);
  EXPECT_FALSE(isAsleep(s));
}

TEST(Activity, ARestoredStateIsAwakeOrAsleepAsItWas) {
  SceneParams p = dampedSheet();
  Simulation s(p, sheetCloud());
  run(s, 10);
  const simulation::Snapshot moving = s.snapshot();
  runUntilAsleep(s);
  const simulation::Snapshot sleeping = s.snapshot();
  const std::uint64_t asleep = s.stateHash();
  s.restore(moving);
  run(s, 1);
  EXPECT_FALSE(isAsleep(s));
  s.restore(sleeping);
  run(s, 5);
  EXPECT_TRUE(isAsleep(s));
  EXPECT_EQ(s.stateHash(), asleep);
  s.reset();
  run(s, 1);
  EXPECT_FALSE(isAsleep(s));
}

TEST(Activity, AnEquilibriumThatIsFoundAgainSleepsUntilItsLoadsChange) {
  SceneParams p = dampedSheet();
  p.integrator.type = IntegratorType::kStatic;
  Simulation s(p, sheetCloud());
  runUntilAsleep(s, 5);
  const Points found = s.state().positions;
  run(s, 3);
  EXPECT_EQ(s.state().positions, found);
  s.setForce({"pull", Vec3(1.0, 0.0, 0.0), Vec3(0.1, 0.0, 0.0), 0.2, 0.0, 1e300});
  run(s, 1);
  EXPECT_GT(largestDistance(s.state().positions, found), 1e-4);
}

TEST(Activity, ExplicitEulerSleepsOnlyWhenToldTo) {
  SceneParams p = sheetInBalance();
  p.integrator.type = IntegratorType::kExplicitEuler;
  p.integrator.time_step = 1e-4;
  Simulation by_default(p, sheetCloud());
  run(by_default, 3);
  EXPECT_FALSE(isAsleep(by_default));
  p.sleep.mode = Sleep::kAlways;
  Simulation told(p, sheetCloud());
  run(told, 3);
  EXPECT_TRUE(isAsleep(told));
}

TEST(Activity, OrientedParticlesSleepAsAWholeAndWake) {
  SceneParams p;
  p.model = "oriented_particles";
  p.material.damping = 10.0;
  p.material.thickness = 0.01;
  p.gravity.setZero();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.sleep.quiet_time = kQuietTime;
  p.sleep.tolerance = 1e-4;
  p.oriented_particles.spacing = 0.115;  // with which the jittered sheet holds together
  Simulation s(p, sheetCloud(10));
  runUntilAsleep(s, 2000);
  const std::uint64_t asleep = s.stateHash();
  run(s, 5);
  EXPECT_EQ(s.stateHash(), asleep);
  s.setForce({"pull", Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.01), 0.0, 0.0, 1e300});
  run(s, 1);
  EXPECT_FALSE(isAsleep(s));
  EXPECT_NE(s.stateHash(), asleep);
}

TEST(Activity, RevisionsStayWhereNothingChanges) {
  Simulation s(sheetInBalance(), sheetCloud());
  run(s, 1);
  const std::uint64_t asleep = s.revision(), surface = s.surfaceRevision();
  const Points* made = &s.surface(true).positions;
  run(s, 5);
  EXPECT_EQ(s.revision(), asleep);
  EXPECT_EQ(s.surfaceRevision(), surface);
  EXPECT_FALSE(isSkipped(s, "transfer")) << "what was made of it is still good";
  EXPECT_EQ(*made, s.input().positions);
  s.setForce({"pull", Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.1), 0.1, 0.0, 1e300});
  EXPECT_NE(s.revision(), asleep);
  EXPECT_EQ(s.surfaceRevision(), surface);
  run(s, 2);
  EXPECT_NE(s.surfaceRevision(), surface);
}

TEST(Activity, WhatFallingAsleepLosesIsPartOfTheErrorEstimate) {
  SceneParams p = dampedSheet();
  p.accuracy.estimate = true;
  p.sleep.tolerance = 1e-3;
  Simulation s(p, sheetCloud());
  p.sleep.tolerance = 1e-6;
  Simulation wakeful(p, sheetCloud());
  const int steps = runUntilAsleep(s);
  run(wakeful, steps);
  EXPECT_FALSE(isAsleep(wakeful));
  const double lost = s.statistics().error_estimate - wakeful.statistics().error_estimate;
  EXPECT_GT(lost, 1e-6);
  EXPECT_LE(s.statistics().error_time - wakeful.statistics().error_time, 2e-3);
}

}  // namespace
}  // namespace deformable_surface::test
