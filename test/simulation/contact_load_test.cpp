#include "deformable_surface/simulation/contact_load.h"
#include "../../src/simulation/points_between.h"
#include "clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace deformable_surface::test {
namespace {

tool::ToolParams ball(double radius, const Vec3& from, const Vec3& to) {
  tool::ToolParams tool;
  tool.id = "ball";
  tool.shape.radius = radius;
  tool.path = {{0.0, from, Vec4(0.0, 0.0, 0.0, 1.0)}, {1.0, to, Vec4(0.0, 0.0, 0.0, 1.0)}};
  return tool;
}

TEST(ContactLoad, PushesAlongMinusTheGradientOfItsPotential) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-0.6, 0.6);
  model::State state;
  for (int i = 0; i < 40; ++i) state.positions.emplace_back(u(random), u(random), u(random));
  state.velocities.assign(40, Vec3::Zero());
  const std::vector<double> masses(40, 0.3);
  for (geometry::Solid::Kind kind : {geometry::Solid::Kind::kSphere, geometry::Solid::Kind::kBox, geometry::Solid::Kind::kCone}) {
    tool::ToolParams tool = ball(0.5, Vec3::Zero(), Vec3(0.2, 0.0, 0.0));
    tool.shape.kind = kind;
    tool.shape.size = Vec3(0.7, 0.8, 0.9);
    tool.shape.height = 0.9;
    tool.path[1].orientation = Vec4(0.6, 0.0, 0.0, 0.8);
    simulation::ContactLoad load(masses);
    load.setTools({tool});
    load.setRate(100.0);
    std::vector<double> areas(40, 1.0);  // pads are stiffer than the penalty at half of the points
    std::fill_n(areas.begin(), 20, 0.01);
    load.setCompliance(1e-4, {areas, 0.0});
    Points forces(40, Vec3::Zero());
    load.addForces(0.7, state, forces);
    int touched = 0;
    const double step = 1e-6;
    for (int i = 0; i < 40; ++i) {
      if (!forces[i].isZero()) ++touched;
      for (int c = 0; c < 3; ++c) {
        model::State moved = state;
        moved.positions[i][c] += step;
        const double above = load.potential(0.7, moved);
        moved.positions[i][c] -= 2.0 * step;
        EXPECT_NEAR(forces[i][c], -(above - load.potential(0.7, moved)) / (2.0 * step), 1e-5 * 0.3 * 1e4);
      }
    }
    EXPECT_GT(touched, 3);
  }
}

// Most points are skipped by the boxes around runs of points and the ball around a tool. The result is that of a check of all
// points.
TEST(ContactLoad, PointsBeyondAToolsReachAreLeftOutAndNoOthers) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  model::State state;
  for (int i = 0; i < 3000; ++i) state.positions.emplace_back(u(random), u(random), u(random));
  std::sort(state.positions.begin(), state.positions.end(), [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); });
  state.velocities.assign(3000, Vec3::Zero());
  const std::vector<double> masses(3000, 0.3);
  using Kind = geometry::Solid::Kind;
  for (const tool::Mode mode : {tool::Mode::kSolid, tool::Mode::kAttract})
    for (const Kind kind : {Kind::kSphere, Kind::kBox, Kind::kCylinder, Kind::kCone, Kind::kPlane}) {
      tool::ToolParams tool = ball(0.3, Vec3(0.2, -0.1, 0.3), Vec3(0.3, 0.1, 0.0));
      tool.mode = mode;
      tool.strength = 20.0;
      tool.reach = 0.2;
      tool.shape.kind = kind;
      tool.shape.size = Vec3(0.7, 0.3, 0.9);
      tool.shape.height = 0.9;
      tool.path[1].orientation = Vec4(0.6, 0.0, 0.0, 0.8);
      simulation::ContactLoad load(masses);
      load.setTools({tool});
      load.setRate(100.0);
      Points forces(3000, Vec3::Zero());
      load.addForces(0.4, state, forces);
      const tool::Pose pose = tool::interpolate(tool.path, 0.4);
      int touched = 0;
      for (int i = 0; i < 3000; ++i) {
        const double distance = tool::findSignedDistance(tool.shape, pose, state.positions[i]).distance;
        const bool expected = mode == tool::Mode::kSolid ? distance < 0.0 : std::abs(distance) < tool.reach;
        ASSERT_EQ(!forces[i].isZero(0.0), expected) << i << " " << static_cast<int>(kind);
        touched += expected;
      }
      EXPECT_GT(touched, 15);
    }
}

// Of a sheet with runs of points in rows, or with each run all over the sheet, so that no run is skipped: the points that a fast
// tool passes over in a step, those that it has passed over at the end, and those near damped tools.
TEST(ContactLoad, RunsOfPointsThatAreSkippedChangeNothing) {
  using Kind = geometry::Solid::Kind;
  constexpr Index kSide = 24, n = kSide * kSide;
  std::vector<Index> scattered(n);
  for (Index i = 0; i < n; ++i) scattered[i] = i * 35 % n;  // 35 and n have no common divisor
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const std::vector<char> held(n, 0);
  std::size_t num_passed = 0, num_near = 0;
  for (int k = 0; k < 60; ++k) {
    model::State rows, all_over;
    for (model::State* state : {&rows, &all_over}) {
      state->positions.resize(n);
      state->velocities.resize(n);
    }
    for (Index i = 0; i < n; ++i) {
      rows.positions[i] = Vec3(0.04 * (i / kSide), 0.04 * (i % kSide), 0.01 * u(random));
      rows.velocities[i] = 0.5 * Vec3(u(random), u(random), u(random));
      all_over.positions[scattered[i]] = rows.positions[i];
      all_over.velocities[scattered[i]] = rows.velocities[i];
    }
    tool::ToolParams tool = ball(0.02, Vec3(0.5 + 0.4 * u(random), 0.5 + 0.4 * u(random), 0.3 * u(random)), Vec3::Zero());
    tool.shape.kind = k % 2 == 0 ? Kind::kCylinder : Kind::kSphere;
    tool.shape.height = 0.4;
    tool.path[0].orientation = Vec4(u(random), u(random), u(random), u(random)).normalized();
    tool.path[1].time = 0.05;
    tool.path[1].position = tool.path[0].position + 0.3 * Vec3(u(random), u(random), u(random));
    tool.path[1].orientation = Vec4(u(random), u(random), u(random), u(random)).normalized();
    tool.friction = 0.5;
    const std::vector<double> masses(n, 1.0);
    simulation::ContactLoad of_rows(masses), of_all(masses);
    const auto listPassed = [&](const simulation::ContactLoad& load, const auto& number) {
      std::vector<Index> passed;
      for (const auto& item : load.all()[0].passed) passed.push_back(number(item.point));
      std::sort(passed.begin(), passed.end());
      return passed;
    };
    const auto listNear = [&](const simulation::ContactLoad& load, const model::State& state, const auto& number) {
      std::vector<Index> near;
      load.forEachNearDamped(0.0, state, [&](Index i) { near.push_back(number(i)); });
      std::sort(near.begin(), near.end());
      return near;
    };
    const auto same = [](Index i) { return i; };
    const auto scatter = [&](Index i) { return scattered[i]; };
    for (simulation::ContactLoad* load : {&of_rows, &of_all}) {
      load->setArriving(false);
      load->setTools({tool});
      load->setRate(1000.0);
    }
    of_rows.beginStep(0.0, 0.05, rows, held);
    of_all.beginStep(0.0, 0.05, all_over, held);
    EXPECT_EQ(listPassed(of_rows, scatter), listPassed(of_all, same)) << k;
    EXPECT_EQ(listNear(of_rows, rows, scatter), listNear(of_all, all_over, same)) << k;
    num_passed += of_rows.all()[0].passed.size();
    num_near += listNear(of_rows, rows, same).size();
    for (model::State* state : {&rows, &all_over})
      for (Index i = 0; i < n; ++i) state->positions[i] -= 0.05 * state->velocities[i];
    const std::vector<model::WeightedTriangle> no_triangles;
    of_rows.endStep(0.0, 0.05, rows, held, {no_triangles, false, 0.04});
    of_all.endStep(0.0, 0.05, all_over, held, {no_triangles, false, 0.04});
    EXPECT_EQ(listPassed(of_rows, scatter), listPassed(of_all, same)) << k;
  }
  EXPECT_GT(num_passed, 50u);
  EXPECT_GT(num_near, 100u);
}

// A ball waits, then goes straight over a point or around it, with many waypoints in a step.
TEST(ContactLoad, EveryCornerOfAPathCountsInAStep) {
  const std::vector<double> masses(1, 1.0);
  model::State state;
  state.positions = {Vec3::Zero()};
  state.velocities = {Vec3::Zero()};
  for (const bool goes_over : {false, true}) {
    constexpr int kCorners = 300;
    constexpr double kRadius = 0.3, kStep = 0.1;
    tool::ToolParams tool = ball(0.02, Vec3::Zero(), Vec3::Zero());
    tool.path.clear();
    for (int k = 0; k <= kCorners; ++k) {
      const double share = static_cast<double>(k) / kCorners, angle = M_PI * std::max(0.0, 3.0 * share - 2.0);
      // Over the point, then back around it; or only around it.
      Vec3 place = kRadius * Vec3(-std::cos(angle), std::sin(angle), 0.0);
      if (goes_over) place.x() *= -1.0;
      if (goes_over && share < 0.5) place = Vec3(-kRadius, 0.0, 0.0);
      tool.path.push_back({kStep * share, place, Vec4(0.0, 0.0, 0.0, 1.0)});
    }
    simulation::ContactLoad load(masses);
    load.setArriving(false);
    load.setTools({tool});
    load.setRate(1000.0);
    load.beginStep(0.0, kStep, state, {0});
    EXPECT_EQ(load.all()[0].passed.size(), goes_over ? 1u : 0u);
  }
}

// Potentials of a moment before do not tell the power: points that hardly touch do not touch yet.
TEST(ContactLoad, KnowsThePowerThatMovesAToolAlsoWherePointsHardlyTouch) {
  model::State state;
  for (const double depth : {1e-6, 3e-6, 1e-5, 1e-4, 1e-2})
    state.positions.push_back((0.3 - depth) * Vec3(depth, 1.0 - depth, 0.5).normalized());
  state.velocities.assign(state.positions.size(), Vec3::Zero());
  const std::vector<double> masses(state.positions.size(), 0.3);
  const auto shift = [](double time) -> Vec3 { return (time - 0.5) * Vec3(0.2, 0.9, 0.3); };
  for (const tool::Mode mode : {tool::Mode::kSolid, tool::Mode::kAttract}) {
    tool::ToolParams tool = ball(0.3, shift(0.0), shift(1.0));
    tool.path[0].orientation = Vec4(0.0, 0.0, std::sin(-0.5), std::cos(-0.5));
    tool.path[1].orientation = Vec4(0.0, 0.0, std::sin(0.5), std::cos(0.5));
    tool.mode = mode;
    tool.reach = 0.1;
    tool.strength = 50.0;
    simulation::ContactLoad load(masses);
    load.setTools({tool});
    load.setRate(100.0);
    const double instant = 1e-7, step = 0.01;
    const double power = (load.potential(0.5 + instant, state) - load.potential(0.5 - instant, state)) / (2.0 * instant);
    ASSERT_GT(std::abs(power), 1e-3);
    EXPECT_NEAR(load.drivingPower(0.5, step, state), power, 1e-5 * std::abs(power));
    // Where the path ends, the power is that of the motion before.
    for (Vec3& x : state.positions) x += shift(1.0);
    EXPECT_NEAR(load.drivingPower(1.0, step, state), power, 1e-5 * std::abs(power));
    for (Vec3& x : state.positions) x -= shift(1.0);
  }
}

TEST(ContactLoad, KnowsHowFastASurfaceComesBack) {
  const simulation::ContactLoad::Withdrawal withdrawal{0.01, 1.0, 0.02};
  const double instant = 1e-6;
  for (const double time : {1.0 + instant, 1.1, 1.3})
    EXPECT_NEAR(withdrawal.rateAt(time), (withdrawal.at(time - instant) - withdrawal.at(time + instant)) / (2.0 * instant), 1e-8);
  EXPECT_EQ(withdrawal.rateAt(3.0), 0.0);
  EXPECT_EQ(simulation::ContactLoad::Withdrawal{}.rateAt(0.0), 0.0);
}

// Implicit Euler took each of these steps, since work of the box was missing where uneven points hardly touch it.
TEST(ContactLoad, ImplicitStepsOnARisingBoxAreOfSecondOrder) {
  simulation::SceneParams p;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.accuracy.estimate = false;
  p.contact.self = false;
  p.sleep.mode = simulation::Sleep::kNever;
  p.material.young_modulus = 2e5;
  p.material.thickness = 2e-3;
  p.material.density = 300.0;
  p.material.damping = 0.0;
  p.integrator.type = solve::IntegratorType::kImplicit;
  p.integrator.time_step = 0.01;
  tool::ToolParams box = ball(0.05, Vec3(0.0, 0.0, -0.1), Vec3(0.0, 0.0, 0.7));
  box.shape.kind = geometry::Solid::Kind::kBox;
  box.shape.size = Vec3(0.9, 0.9, 0.1);
  box.friction = 0.5;
  p.tools = {box};
  simulation::Simulation s(p, asCloud(makeSheet(10, 11, 0.3, 0.3, 0.4).points));
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(s.step().ok);
  const Index before = s.statistics().fallback_steps;
  for (int k = 0; k < 40; ++k) EXPECT_TRUE(s.step().ok);
  EXPECT_EQ(s.statistics().fallback_steps, before);
  for (const Vec3& v : s.state().velocities) EXPECT_NEAR(v.z(), 0.8, 1e-3);
}

TEST(ContactLoad, StatisticsTellThatContactIsLeftOutUntilAToolComesNear) {
  simulation::SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.tools = {ball(0.1, Vec3(0.5, 0.5, 2.0), Vec3(0.5, 0.5, 0.0))};
  simulation::Simulation s(p, sheetCloud());
  const auto skipsContact = [&] {
    const std::vector<std::string> skipped = s.statistics().skipped;
    return std::count(skipped.begin(), skipped.end(), "contact") == 1;
  };
  EXPECT_TRUE(skipsContact());
  while (s.time() < 0.9) run(s, 1);
  EXPECT_TRUE(skipsContact());
  bool has_come = false;  // the sheet bounces off
  while (s.time() < 0.99) {
    run(s, 1);
    has_come = has_come || !skipsContact();
  }
  EXPECT_TRUE(has_come);
  s.removeTool("ball");
  EXPECT_TRUE(skipsContact());
}

TEST(ContactLoad, AFreeSheetRestsOnAPlaneAndNoPointSinksIn) {
  simulation::SceneParams p = hangingSheet();
  p.pins.clear();
  p.integrator.type = solve::IntegratorType::kStatic;
  tool::ToolParams floor = ball(0.1, Vec3(0.0, 0.0, -0.02), Vec3(0.0, 0.0, -0.02));
  floor.shape.kind = geometry::Solid::Kind::kPlane;
  floor.path.resize(1);
  p.tools = {floor};
  p.material.young_modulus = 1e7;
  simulation::Simulation s(p, sheetCloud());
  run(s, 1);
  double low = 0.0, high = -1.0;
  for (const Vec3& x : s.state().positions) {
    low = std::min(low, x.z());
    high = std::max(high, x.z());
  }
  // Each point carries its own weight: the penalty alone leaves them all equally deep, g / r^2, micrometres with so stiff a
  // sheet.
  EXPECT_NEAR(low, high, 1e-8);
  EXPECT_NEAR(low, -0.02, 1e-8);
}

TEST(ContactLoad, ASheetThatFallsOnABallDrapesOverIt) {
  simulation::SceneParams p = hangingSheet();
  p.pins.clear();
  p.material.damping = 2.0;
  p.material.young_modulus = 1e7;
  p.tools = {ball(0.25, Vec3(0.5, 0.0, -0.3), Vec3(0.5, 0.0, -0.3))};
  simulation::Simulation s(p, sheetCloud());
  run(s, 40);
  double nearest = 1.0, lowest = 0.0;
  for (const Vec3& x : s.surface(false).positions) {
    nearest = std::min(nearest, (x - Vec3(0.5, 0.0, -0.3)).norm() - 0.25);
    lowest = std::min(lowest, x.z());
  }
  EXPECT_LT(nearest, 0.0);
  EXPECT_GT(nearest, -1e-3);
  EXPECT_LT(lowest, -0.3);  // without the ball it would have fallen flat by 0.6 m
}

TEST(ContactLoad, AToolThatComesUpUnderARestingSheetIsNotTakenForABlowUp) {
  // At first contact nearly all energy is in the contact itself.
  simulation::SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.material.damping = 5.0;
  p.integrator.type = solve::IntegratorType::kVerlet;
  p.tools = {ball(0.15, Vec3(0.5, 0.0, -0.3), Vec3(0.5, 0.0, 0.1))};
  simulation::Simulation s(p, sheetCloud());
  run(s, 80);
  EXPECT_GT(s.statistics().max_speed, 0.01);
}

TEST(ContactLoad, AToolFarAwayChangesNothing) {
  for (const solve::IntegratorType type : {solve::IntegratorType::kSymplecticEuler, solve::IntegratorType::kVerlet}) {
    simulation::SceneParams p = hangingSheet();
    p.integrator.type = type;
    if (type == solve::IntegratorType::kSymplecticEuler) p.integrator.time_step = 1e-4;
    simulation::Simulation without(p, sheetCloud());
    p.tools = {ball(0.25, Vec3(5.0, 5.0, 0.0), Vec3(5.0, 5.0, 0.0))};
    p.tools[0].friction = 0.5;
    simulation::Simulation with(p, sheetCloud());
    run(without, 20);
    run(with, 20);
    EXPECT_EQ(with.stateHash(), without.stateHash()) << static_cast<int>(type);
  }
}

TEST(ContactLoad, OnlyToolsThatComeNearMayDampTheMotion) {
  const std::vector<double> masses(1, 2.0);
  model::State state;
  state.positions = {Vec3(1.0, 0.0, 0.0)};
  state.velocities = {Vec3(-2.0, 0.0, 0.0)};
  const auto mayBeDamped = [&](double friction, double within) {
    tool::ToolParams tool = ball(0.5, Vec3::Zero(), Vec3::Zero());
    tool.friction = friction;
    simulation::ContactLoad load(masses);
    load.setTools({tool});
    return load.mayBeDamped(0.0, within, state);
  };
  EXPECT_FALSE(mayBeDamped(0.3, 0.2));
  EXPECT_TRUE(mayBeDamped(0.3, 0.3));  // it will be 0.1 m deep
  EXPECT_FALSE(mayBeDamped(0.0, 0.3));
  state.positions[0].x() = 0.4;
  EXPECT_TRUE(mayBeDamped(0.3, 0.0));
}

TEST(ContactLoad, AttractionIsMinusTheGradientOfItsPotentialAndEndsAtItsReach) {
  const std::vector<double> masses(1, 2.0);
  tool::ToolParams tool = ball(0.5, Vec3::Zero(), Vec3::Zero());
  tool.mode = tool::Mode::kAttract;
  tool.strength = 30.0;
  tool.reach = 0.2;
  simulation::ContactLoad load(masses);
  load.setTools({tool});
  const auto potentialAt = [&](double x) {
    model::State state;
    state.positions = {Vec3(x, 0.0, 0.0)};
    return load.potential(0.0, state);
  };
  for (double x : {0.35, 0.45, 0.5, 0.58, 0.69, 0.75}) {
    model::State state;
    state.positions = {Vec3(x, 0.0, 0.0)};
    Points forces(1, Vec3::Zero());
    load.addForces(0.0, state, forces);
    EXPECT_NEAR(forces[0].x(), -(potentialAt(x + 1e-6) - potentialAt(x - 1e-6)) / 2e-6, 1e-7) << x;
    EXPECT_GE((0.5 - x) * forces[0].x(), 0.0);  // towards the surface
  }
  EXPECT_EQ(potentialAt(0.71), 0.0);
}

TEST(ContactLoad, WhatATableFeelsIsTheWeightOfTheSheetOnIt) {
  simulation::SceneParams p = hangingSheet();
  p.pins.clear();
  p.integrator.type = solve::IntegratorType::kStatic;
  p.material.young_modulus = 1e7;
  tool::ToolParams table = ball(0.1, Vec3(0.5, 0.2, -0.02), Vec3::Zero());
  table.shape.kind = geometry::Solid::Kind::kPlane;
  table.path.resize(1);
  const double half = std::sqrt(0.5);
  table.path[0].orientation = Vec4(0.0, 0.0, half, half);  // its x axis points along the world's y
  p.tools = {table};
  simulation::Simulation s(p, sheetCloud());
  run(s, 1);
  const simulation::ToolReaction reaction = s.toolReactions().front();
  double mass = 0.0;
  Vec3 moment = Vec3::Zero();
  for (Index i = 0; i < s.state().size(); ++i) {
    mass += s.model().masses()[i];
    moment += (s.state().positions[i] - table.path[0].position).cross(s.model().masses()[i] * p.gravity);
  }
  EXPECT_EQ(reaction.id, "ball");
  EXPECT_EQ(reaction.contacts, s.state().size());
  EXPECT_TRUE(reaction.force.isApprox(mass * p.gravity, 1e-5)) << reaction.force.transpose();
  EXPECT_NEAR(reaction.torque.x(), moment.y(), 1e-5 * moment.norm());
  EXPECT_NEAR(reaction.torque.y(), -moment.x(), 1e-5 * moment.norm());
  EXPECT_LT(reaction.penetration, 1e-8);
}

// A ball under a sheet between two held sides: in equilibria points lie on it. In motion the depth that the penalty leaves stays.
TEST(ContactLoad, InEquilibriaPointsLieOnTheTool) {
  const auto findDepth = [](solve::IntegratorType type, double damping) {
    const bool is_static = type == solve::IntegratorType::kStatic;
    simulation::SceneParams p = hangingSheet();
    p.integrator.type = type;
    p.material.damping = damping;
    p.pins.push_back(p.pins.front());
    p.pins.back().region.min.x() = 0.999;
    p.pins.back().region.max.x() = 1.001;
    const Vec3 high(0.5, 0.0, -0.2);
    p.tools = {ball(0.3, is_static ? high : Vec3(0.5, 0.0, -0.35), high)};
    simulation::Simulation s(p, sheetCloud());
    run(s, is_static ? 1 : static_cast<int>(3.0 / p.integrator.time_step));
    EXPECT_GT(s.toolReactions().front().contacts, 2);
    EXPECT_GT(s.toolReactions().front().force.norm(), 0.01);
    return s.toolReactions().front().penetration;
  };
  const double moving = findDepth(solve::IntegratorType::kImplicit, 8.0);
  EXPECT_GT(moving, 1e-5);
  EXPECT_LT(findDepth(solve::IntegratorType::kStatic, 0.0), 0.05 * moving);
}

// A flat sheet lies a little in a large box or cylinder and is moved along its face, until that ends below its middle.
void testEdgesOf(geometry::Solid::Kind kind) {
  const simulation::SceneParams p = hangingSheet();
  const simulation::RestSurface rest = simulation::buildRestSurface(p, sheetCloud(40));
  const std::vector<double> masses = rest.model->masses();
  const Index n = static_cast<Index>(masses.size());
  const Vec3 normal = rest.normals.front(), along = normal.unitOrthogonal();
  tool::ToolParams tool = ball(0.1, Vec3::Zero(), Vec3::Zero());
  tool.shape.kind = kind;
  tool.shape.size = Vec3(6.0, 6.0, 6.0);
  tool.shape.radius = 3.0;
  tool.shape.height = 6.0;
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond((Mat3() << along, normal.cross(along), normal).finished());  // the face is that of the z axis
  for (auto& waypoint : tool.path) {
    waypoint.position = rest.points.front() - (3.0 - 1e-3) * normal;
    waypoint.orientation = turn.coeffs();
  }
  for (const double compliance : {0.0, 1e-4}) {
    simulation::ContactLoad load(masses);
    load.setBetween(simulation::choosePointsBetween(p, rest.dense, rest, true));
    load.setTools({tool});
    load.setRate(100.0);
    load.setCompliance(compliance, {std::vector<double>(n, 0.01), 0.0});
    model::State state;
    state.velocities.assign(n, Vec3::Zero());
    const auto moveBy = [&](double way, double up = 0.0) {
      state.positions = rest.points;
      for (Vec3& x : state.positions) x += way * along + up * normal;
    };
    const auto potentialAt = [&](double way, double up = 0.0) {
      moveBy(way, up);
      return load.potential(0.0, state);
    };
    const auto countTouches = [&] { return static_cast<Index>(load.findTouches(0.0, state)[0].size()); };
    moveBy(0.0);
    EXPECT_EQ(countTouches(), n);
    Index most = 0;
    for (double way = 1.0; way < 3.0; way += 0.05) {
      const double step = 1e-5, change = potentialAt(way + step) - potentialAt(way - step);
      const double lift = 1e-7, drop = potentialAt(way, -lift) - potentialAt(way, lift);
      moveBy(way);
      most = std::max(most, countTouches());
      bool is_at_edge = false;  // with points of its cell, which would be pushed sideways
      for (const Vec3& x : state.positions) is_at_edge = is_at_edge || (x - tool.path[0].position).dot(along) > 3.0 - 0.15;
      if (is_at_edge) break;
      Points forces(n, Vec3::Zero());
      load.addForces(0.0, state, forces);
      Vec3 force = Vec3::Zero();
      for (const Vec3& f : forces) force += f;
      EXPECT_NEAR(force.dot(along), -change / (2.0 * step), 1e-6 * load.potential(0.0, state)) << way;
      EXPECT_NEAR(force.dot(normal), drop / (2.0 * lift), 1e-5 * force.norm()) << way;
    }
    EXPECT_GT(most, 2 * n);
  }
}

TEST(ContactLoad, FarFromTheEdgesOfABoxOnlySimulationPointsTouchAndTheChangeIsConservative) {
  testEdgesOf(geometry::Solid::Kind::kBox);
}

TEST(ContactLoad, FarFromTheRimOfACylinderOnlySimulationPointsTouchItsCapAndTheChangeIsConservative) {
  testEdgesOf(geometry::Solid::Kind::kCylinder);
}

}  // namespace
}  // namespace deformable_surface::test
