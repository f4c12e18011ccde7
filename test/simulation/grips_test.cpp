#include "deformable_surface/simulation/grips.h"
#include "clouds.h"
#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace deformable_surface::test {
namespace {

// A tool that grips the free edge of the hanging sheet at time 0 and lifts it.
tool::ToolParams hand(double strength = 0.0) {
  tool::ToolParams tool;
  tool.id = "hand";
  tool.mode = tool::Mode::kMove;
  tool.shape.kind = geometry::Solid::Kind::kBox;
  tool.shape.size = Vec3(0.1, 2.0, 0.1);
  tool.strength = strength;
  const double half = 0.5 * 0.6;  // of the angle turned
  tool.path = {{0.0, Vec3(1.0, 0.0, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)},
               {0.5, Vec3(0.9, 0.1, 0.2), Vec4(0.0, std::sin(half), 0.0, std::cos(half))}};
  return tool;
}

TEST(Grips, WhatItHoldsGoesWhereItGoes) {
  simulation::SceneParams p = hangingSheet();
  p.tools = {hand()};
  simulation::Simulation s(p, sheetCloud());
  const Points rest = s.state().positions;
  run(s, 80);
  const Eigen::AngleAxisd turn(0.6, Vec3::UnitY());
  int held = 0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const Vec3 place = Vec3(0.9, 0.1, 0.2) + turn * (rest[i] - Vec3(1.0, 0.0, 0.0));
    const bool is_held = (s.state().positions[i] - place).norm() < 1e-9;
    EXPECT_TRUE(is_held || rest[i].x() < 0.951);
    EXPECT_FALSE(is_held && rest[i].x() < 0.9) << "farther from the edge of the tool than points ride";
    held += is_held;
  }
  EXPECT_EQ(s.toolReactions().front().contacts, held);
  EXPECT_GT(held, 3);
}

// A pin on a path of 1 m/s that contact has held back.
TEST(Grips, WhatWasHeldBackCatchesUpAtTwiceTheFastestSpeedOfItsPath) {
  const auto at = [](double time, double x) { return tool::WaypointParams{time, Vec3(x, 0.0, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)}; };
  model::State state;
  state.positions = {Vec3(0.0, 0.0, 0.0)};
  state.velocities = {Vec3::Zero()};
  simulation::Grips grips;
  grips.addPin("pins[0]", {at(0.0, 0.0), at(1.0, 1.0)}, 0.0, {0}, state);
  std::vector<char> held(1);
  const auto findSpeed = [&](double time, double x, bool at_once = false) {
    state.positions[0].x() = x;
    grips.carry(time, 0.1, at_once, state, held);
    return state.velocities[0].x();
  };
  EXPECT_NEAR(findSpeed(0.4, 0.0), 5.0, 1e-12) << "in the first step there is nothing to catch up";
  EXPECT_NEAR(findSpeed(0.5, 0.5), 1.0, 1e-12) << "on its path";
  EXPECT_NEAR(findSpeed(0.6, 0.55), 1.5, 1e-12) << "the rest of the way is shorter than a step";
  EXPECT_NEAR(findSpeed(0.7, -0.5), 2.0, 1e-12);
  EXPECT_NEAR(findSpeed(0.8, -0.5, true), 14.0, 1e-12);
  EXPECT_NEAR(findSpeed(0.9, 0.0), 2.0, 1e-12);
  EXPECT_NEAR(findSpeed(1.0, 0.0), 2.0, 1e-12) << "after the end of the path";
  grips.movePin("pins[0]", {at(1.1, 5.0), at(2.1, 5.1)});
  EXPECT_NEAR(findSpeed(1.1, 1.0), 40.1, 1e-12) << "a new path that begins elsewhere";
  EXPECT_NEAR(findSpeed(1.2, 4.5), 0.2, 1e-12) << "held back on the way to it";
  grips.movePin("pins[0]", {at(0.0, 5.02)});
  EXPECT_NEAR(findSpeed(1.3, 4.5), 5.2, 1e-12) << "a pose that rests";
}

// Half a turn about a place 1 m away, in one second.
TEST(Grips, TheFastestSpeedOfAPathIsAlongItsArc) {
  model::State state;
  state.positions = {Vec3(1.0, 0.0, 0.0)};
  state.velocities = {Vec3::Zero()};
  simulation::Grips grips;
  grips.addPin("pins[0]", {{0.0, Vec3::Zero(), Vec4(0.0, 0.0, 0.0, 1.0)}, {1.0, Vec3::Zero(), Vec4(0.0, 0.0, 1.0, 0.0)}}, 0.0,
               {0}, state);
  std::vector<char> held(1);
  for (const double time : {1.0, 1.1}) grips.carry(time, 0.1, false, state, held);
  EXPECT_NEAR(state.velocities[0].norm(), 2.0 * kPi, 1e-6);
}

// The edge of a sheet is pinned and goes down through another sheet, which stops it, and up again.
TEST(Grips, APinThatContactHasHeldBackComesFreeAndArrives) {
  simulation::SceneParams p;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.material.thickness = 0.002;
  p.material.density = 125.0;
  p.material.young_modulus = 5e4;
  p.contact.self = true;
  p.gravity.setZero();
  p.integrator.time_step = 0.005;
  p.accuracy.estimate = false;
  cloud::PointCloud cloud;
  for (const double height : {0.0, 0.1})
    for (int i = 0; i < 9; ++i)
      for (int j = 0; j < 9; ++j) cloud.positions.emplace_back(0.02 * i, 0.02 * j, height);
  cloud.width = cloud.size();
  simulation::PinParams below, above;
  below.region.min = Vec3(-1.0, -1.0, -1.0);
  below.region.max = Vec3(1.0, 1.0, 0.05);
  above.region.min = Vec3(-1.0, -1.0, 0.05);
  above.region.max = Vec3(0.01, 1.0, 1.0);
  const Vec4 upright(0.0, 0.0, 0.0, 1.0);
  above.path = {{0.0, Vec3::Zero(), upright}, {0.3, Vec3(0.05, 0.0, -0.3), upright}, {0.6, Vec3::Zero(), upright}};
  p.pins = {below, above};
  simulation::Simulation s(p, cloud);
  double fastest = 0.0, lowest = 1.0;
  for (int step = 0; step < 160; ++step) {
    ASSERT_TRUE(s.step().ok);
    for (Index i = 81; i < 90; ++i) {
      fastest = std::max(fastest, s.state().velocities[i].norm());
      lowest = std::min(lowest, s.state().positions[i].z());
    }
  }
  EXPECT_GT(lowest, 0.0);  // the path goes down to -0.2 m
  EXPECT_LT(fastest, 2.1 * above.path[1].position.norm() / 0.3);
  for (Index i = 81; i < 90; ++i) EXPECT_LT((s.state().positions[i] - cloud.positions[i]).norm(), 1e-9);
}

TEST(Grips, EveryMethodCarriesAlike) {
  for (auto type : {solve::IntegratorType::kSymplecticEuler, solve::IntegratorType::kImplicit, solve::IntegratorType::kStatic}) {
    simulation::SceneParams p = hangingSheet();
    p.tools = {hand()};
    p.integrator.type = type;
    simulation::Simulation s(p, sheetCloud());
    const Points rest = s.state().positions;
    run(s, 60);
    const Eigen::AngleAxisd turn(0.6, Vec3::UnitY());
    for (std::size_t i = 0; i < rest.size(); ++i) {
      if (rest[i].x() < 0.951) continue;
      EXPECT_LT((s.state().positions[i] - Vec3(0.9, 0.1, 0.2) - turn * (rest[i] - Vec3(1.0, 0.0, 0.0))).norm(), 1e-9);
    }
  }
}

// Hardly wider than the spacing of the simulation points, but several of those of the cloud.
TEST(Grips, NarrowOnesClampAsPinsDo) {
  simulation::SceneParams p;
  p.material.young_modulus = 1e6;
  p.material.thickness = 0.01;
  p.material.density = 200.0;
  p.gravity = Vec3(0.0, 0.0, -0.02);
  p.integrator.type = solve::IntegratorType::kStatic;
  p.simplification.target_points = 150;
  simulation::PinParams pin;
  pin.region.kind = geometry::Region::Kind::kSphere;
  pin.region.center = Vec3(0.0, 0.35, 0.0);
  pin.region.radius = 0.06;
  tool::ToolParams grip;
  grip.id = "grip";
  grip.mode = tool::Mode::kMove;
  grip.shape.kind = geometry::Solid::Kind::kSphere;
  grip.shape.radius = pin.region.radius;
  grip.path = {{0.0, pin.region.center}};
  simulation::SceneParams pinned = p;
  pinned.pins = {pin};
  p.tools = {grip};
  const cloud::PointCloud cloud = asCloud(makeSheet(50, 50, 1.0, 0.6, 0.3).points);
  simulation::Simulation by_pin(pinned, cloud), by_grip(p, cloud);
  run(by_pin, 1);
  const std::string notice = by_grip.step().notice;
  EXPECT_NE(notice.find("tool 'grip' holds only "), std::string::npos) << notice;
  const auto findLargest = [](simulation::Simulation& s) {
    const std::vector<float> displacement = s.surface(false).displacement;
    return *std::max_element(displacement.begin(), displacement.end());
  };
  EXPECT_NEAR(findLargest(by_grip), findLargest(by_pin), 1e-3 * findLargest(by_pin));
}

// More than patches have numbers.
TEST(Grips, HoweverManyThereAreNoneIsOfThePatchOfTheFixedPoints) {
  constexpr Index kGrips = 300;
  model::State state;
  state.positions.assign(kGrips + 1, Vec3::Zero());
  simulation::Grips grips;
  for (Index i = 0; i < kGrips; ++i)
    grips.addPin("pins[" + std::to_string(i) + "]", {{0.0, Vec3::Zero(), Vec4(0.0, 0.0, 0.0, 1.0)}}, 0.0, {i}, state);
  std::vector<char> patches(kGrips + 1, 1);
  std::vector<model::ClampEdge> edges;
  grips.addPatches(patches, edges);
  EXPECT_EQ(patches[kGrips], 1);
  for (Index i = 0; i < kGrips; ++i) {
    EXPECT_GT(patches[i], 1) << i;
    EXPECT_NE(patches[i], patches[i + 1]) << i;
  }
}

// The caller chooses how far it moves in a step, and what it meets there.
TEST(Grips, AnEquilibriumFollowsAHandOverAnyDistanceInAnyDirection) {
  for (const double stretching : {20.0, 2000.0})
    for (const double distance : {0.02, 0.1, 0.25})
      for (const Vec3& along : {Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0.6, 0, 0.8), Vec3(-0.6, 0, -0.8)})
        for (const double weight : {0.0, 9.81}) {
          simulation::SceneParams p = hangingSheet();
          p.accuracy.estimate = false;
          p.material.young_modulus = stretching / p.material.thickness;
          p.gravity = Vec3(0.0, 0.0, -weight);
          p.integrator.type = solve::IntegratorType::kStatic;
          p.integrator.max_iterations = 400;
          p.tools = {hand()};
          const double step = p.integrator.time_step;
          p.tools[0].path = {{0.0, Vec3(1.0, 0.0, 0.0), Vec4(0, 0, 0, 1)},
                             {2.0 * step, Vec3(1.0, 0.0, 0.0) + distance * along, Vec4(0, 0, 0, 1)}};
          simulation::Simulation s(p, sheetCloud(14));
          const Points rest = s.state().positions;
          for (int k = 0; k < 3; ++k) {
            const simulation::StepOutcome outcome = s.step();
            ASSERT_TRUE(outcome.ok) << "E h " << stretching << " by " << distance << " along " << along.transpose() << ", weight "
                                    << weight << ": " << outcome.problem;
          }
          for (std::size_t i = 0; i < rest.size(); ++i) {
            if (rest[i].x() < 0.951) continue;
            EXPECT_LT((s.state().positions[i] - rest[i] - distance * along).norm(), 1e-9);
          }
        }
}

TEST(Grips, AfterItsEndTheSheetFalls) {
  simulation::SceneParams p = hangingSheet();
  p.tools = {hand()};
  p.tools[0].end = 0.5;
  simulation::Simulation s(p, sheetCloud());
  run(s, 50);
  EXPECT_GT(s.toolReactions().front().contacts, 3);
  run(s, 1);
  EXPECT_EQ(s.toolReactions().front().contacts, 0);
  EXPECT_EQ(s.toolReactions().front().force, Vec3::Zero());
}

TEST(Grips, TheHeldWeightIsFeltAndAWeakerHandLetsGoAndSaysSo) {
  simulation::SceneParams p = hangingSheet();
  p.pins.clear();
  p.tools = {hand()};
  p.tools[0].path.resize(1);
  p.integrator.type = solve::IntegratorType::kStatic;
  simulation::Simulation strong(p, sheetCloud());
  run(strong, 2);
  double weight = 0.0;
  for (double m : strong.model().masses()) weight += 9.81 * m;
  EXPECT_NEAR(strong.toolReactions().front().force.z(), -weight, 1e-5 * weight);

  p.integrator.type = solve::IntegratorType::kAuto;
  p.tools[0].strength = 0.5 * weight;
  simulation::Simulation weak(p, sheetCloud());
  std::string notice;
  for (int k = 0; k < 200 && notice.empty(); ++k) notice = weak.step().notice;
  EXPECT_NE(notice.find("tool 'hand' has lost its grip"), std::string::npos) << notice;
  EXPECT_NE(notice.find("takes hold anew (a warm hand in RViz: Take hold)"), std::string::npos) << notice;
  run(weak, 1);
  EXPECT_EQ(weak.toolReactions().front().contacts, 0);
}

TEST(Grips, AllThatAreLostInOneStepAreTold) {
  simulation::SceneParams p = hangingSheet();
  p.pins.clear();
  p.tools = {hand(), hand()};
  p.tools[1].id = "other";
  for (tool::ToolParams& tool : p.tools) {
    tool.path.resize(1);
    tool.strength = 1e-9;
  }
  simulation::Simulation weak(p, sheetCloud());
  std::string notice;
  for (int k = 0; k < 200 && notice.find("lost its grip") == std::string::npos; ++k) notice = weak.step().notice;
  for (const char* id : {"hand", "other"})
    EXPECT_NE(notice.find("tool '" + std::string(id) + "' has lost its grip"), std::string::npos) << notice;
}

TEST(Grips, ASnapshotHoldsTheGrip) {
  simulation::SceneParams p = hangingSheet();
  p.tools = {hand()};
  simulation::Simulation s(p, sheetCloud());
  run(s, 10);
  const simulation::Snapshot snapshot = s.snapshot();
  run(s, 10);
  const std::uint64_t hash = s.stateHash();
  s.removeTool("hand");
  run(s, 5);
  s.restore(snapshot);
  run(s, 10);
  EXPECT_EQ(s.stateHash(), hash);
}

TEST(Simulation, AToolIsGivenAnotherPathOrTheReasonWhyNot) {
  simulation::SceneParams p = hangingSheet();
  p.tools = {hand()};
  simulation::Simulation moved(p, sheetCloud()), given(p, sheetCloud());
  run(moved, 5);
  run(given, 5);
  tool::ToolParams other = hand();
  other.path[1].position.z() = 0.4;
  moved.moveTool("hand", other.path);
  given.setTool(other);
  run(moved, 5);
  run(given, 5);
  EXPECT_EQ(moved.stateHash(), given.stateHash());
  EXPECT_THROW(moved.moveTool("foot", other.path), InputError);
  EXPECT_THROW(moved.moveTool("hand", {}), InputError);
  std::swap(other.path[0], other.path[1]);
  EXPECT_THROW(moved.moveTool("hand", other.path), InputError);
  other.path = {{0.0, Vec3(std::nan(""), 0.0, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)}};
  EXPECT_THROW(moved.moveTool("hand", other.path), InputError);
  other.path = {{0.0, Vec3::Zero(), Vec4::Zero()}};
  EXPECT_THROW(moved.moveTool("hand", other.path), InputError);
}

TEST(Simulation, ToolsThatTheModelHasNotAreRefused) {
  simulation::Simulation s(hangingSheet(), sheetCloud());
  tool::ToolParams iron = hand();
  iron.mode = tool::Mode::kErase;
  EXPECT_THROW(s.setTool(iron), InputError);
  EXPECT_TRUE(s.tools().empty());
  EXPECT_FALSE(s.removeTool("hand"));
}

}  // namespace
}  // namespace deformable_surface::test
