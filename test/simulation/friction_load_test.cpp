#include "deformable_surface/simulation/friction_load.h"

#include "clouds.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/contact_damping.h"
#include "energy_rise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::test {
namespace {

using Type = solve::IntegratorType;

tool::ToolParams ball(double radius, const Vec3& from, const Vec3& to) {
  tool::ToolParams tool;
  tool.id = "ball";
  tool.shape.radius = radius;
  tool.path = {{0.0, from, Vec4(0.0, 0.0, 0.0, 1.0)}, {1.0, to, Vec4(0.0, 0.0, 0.0, 1.0)}};
  return tool;
}

// One force law: the stiffness is the secant of the force, the row bound of the contact's damping is above it, and the work is
// done at the force's limit.
TEST(FrictionLoad, ForceStiffnessWorkAndRowBoundsAreThoseOfOneLaw) {
  const std::vector<double> masses = {0.3, 0.5};
  tool::ToolParams tool = ball(0.5, Vec3::Zero(), Vec3(0.2, 0.0, 0.0));
  tool.friction = 0.4;
  simulation::ContactLoad contact(masses);
  const simulation::FrictionLoad friction(contact);
  contact.setTools({tool});
  contact.setRate(100.0);
  model::State state;
  state.positions = {Vec3(0.45, 0.0, 0.0), Vec3(0.0, 0.49, 0.0)};
  for (const double speed : {1e-3, 0.1, 3.0}) {
    state.velocities = {Vec3(0.0, speed, 0.0), Vec3(0.0, 0.0, speed)};
    Points pushes(2, Vec3::Zero()), forces(2, Vec3::Zero());
    contact.addForces(0.0, state, pushes);
    friction.addForces(0.0, state, forces);
    const double step = 0.01;
    BlockSparse stiffness;
    stiffness.begin(2);
    friction.addStiffness(0.0, state, step, stiffness);
    stiffness.finish();
    std::vector<double> rows(2, 0.0), damping(2, 0.0);
    simulation::ContactDamping(contact).addRowBounds(0.0, state, rows, damping);
    double limits = 0.0;
    const tool::Motion motion = tool::findMotion(tool.path, 0.0);
    for (int i = 0; i < 2; ++i) {
      const Vec3 normal = pushes[i].normalized(), relative = state.velocities[i] - motion.velocityAt(state.positions[i]);
      const Vec3 sliding = relative - relative.dot(normal) * normal;
      Eigen::VectorXd slide = Eigen::VectorXd::Zero(6), product(6);
      slide.segment<3>(3 * i) = sliding;
      stiffness.multiply(slide, product);
      EXPECT_LT((step * product.segment<3>(3 * i) + forces[i]).norm(), 1e-12 * forces[i].norm()) << speed;
      EXPECT_GE(damping[i] * sliding.norm(), (1.0 - 1e-12) * forces[i].norm());
      EXPECT_LE(forces[i].norm(), (1.0 + 1e-12) * tool.friction * pushes[i].norm());
      limits += tool.friction * pushes[i].norm() * step * motion.velocityAt(state.positions[i]).norm();
    }
    EXPECT_NEAR(friction.estimateWork(0.0, step, state, state), limits, 0.05 * limits);
  }
}

TEST(FrictionLoad, AToolThatDoesNotPushRubsNowhere) {
  const std::vector<double> masses = {0.3};
  tool::ToolParams tool = ball(0.5, Vec3::Zero(), Vec3(0.2, 0.0, 0.0));
  tool.mode = tool::Mode::kAttract;
  tool.strength = 10.0;
  tool.reach = 0.2;
  tool.friction = 0.4;  // which scenes and commands refuse
  simulation::ContactLoad contact(masses);
  const simulation::FrictionLoad friction(contact);
  contact.setTools({tool});
  contact.setRate(100.0);
  model::State state;
  state.positions = {Vec3(0.45, 0.0, 0.0)};
  state.velocities = {Vec3(0.0, 1.0, 0.0)};
  EXPECT_TRUE(friction.isEmpty());
  EXPECT_EQ(friction.estimateWork(0.0, 0.01, state, state), 0.0);
}

constexpr double kDamping = 20.0;  // 1/s, with which a patch that falls on a plane comes to rest in half a second

// A small stiff patch on a plane with a coefficient of 0.4. The plane is inclined once the patch has come to rest.
struct Incline {
  double angle = 0.0;  // rad
  double friction = 0.4;
  OrAuto<double> kinetic{};
  Type integrator = Type::kVerlet;
  double damping = kDamping;  // 1/s, once it is inclined
  double rests = 1.0;         // s before; 0: the plane is inclined as the patch is laid down

  simulation::Simulation make() const {
    simulation::SceneParams p = hangingSheet();
    p.pins.clear();
    p.material.damping = kDamping;
    p.material.young_modulus = 1e7;
    p.simplification.target_points = 40;
    p.sleep.mode = simulation::Sleep::kNever;
    p.accuracy.estimate = false;
    p.integrator.type = integrator;
    p.gravity = Vec3(0.0, 0.0, -9.81);
    tool::ToolParams plane = ball(0.1, Vec3::Zero(), Vec3::Zero());
    plane.shape.kind = geometry::Solid::Kind::kPlane;
    plane.path.resize(1);
    plane.friction = friction;
    plane.kinetic_friction = kinetic;
    p.tools = {plane};
    simulation::Simulation s(p, sheetCloud(10));
    run(s, static_cast<int>(std::lround(rests / p.integrator.time_step)));
    s.setGravity(9.81 * Vec3(std::sin(angle), 0.0, -std::cos(angle)));
    s.setDamping(damping);
    return s;
  }
};

double meanPlace(const simulation::Simulation& s) {
  double sum = 0.0;
  for (const Vec3& x : s.state().positions) sum += x.x() / s.state().size();
  return sum;
}

// How far the patch moves between two times after the plane was inclined, m.
double slide(const Incline& incline, double from, double to) {
  simulation::Simulation s = incline.make();
  const double step = s.params().integrator.time_step;
  run(s, static_cast<int>(std::lround(from / step)));
  const double before = meanPlace(s);
  run(s, static_cast<int>(std::lround((to - from) / step)));
  return meanPlace(s) - before;
}

TEST(FrictionLoad, WhatSticksDoesNotCreep) {
  for (const Type type : {Type::kVerlet, Type::kImplicit}) {
    Incline incline;
    incline.integrator = type;
    incline.angle = std::atan(0.9 * 0.4);
    // A micrometre a minute.
    EXPECT_LT(std::abs(slide(incline, 1.0, 3.0)), 2.0 / 60.0 * 1e-6) << static_cast<int>(type);
  }
}

TEST(FrictionLoad, APatchBeginsToSlideWithinHalfADegreeOfTheAngleOfFriction) {
  const double half_degree = 0.5 * M_PI / 180.0;
  Incline incline;
  incline.angle = std::atan(0.4) - half_degree;
  EXPECT_LT(slide(incline, 0.5, 1.0), 1e-7);
  incline.angle = std::atan(0.4) + half_degree;
  EXPECT_GT(slide(incline, 0.0, 1.0), 1e-3);
}

TEST(FrictionLoad, APatchSlidesAsFarAsCoulombSays) {
  for (const Type type : {Type::kVerlet, Type::kImplicit}) {
    for (const double friction : {0.0, 0.2, 0.4}) {
      Incline incline;
      incline.integrator = type;
      incline.friction = friction;
      incline.angle = 0.6;
      incline.damping = 0.0;
      const double expected = 0.5 * 9.81 * (std::sin(0.6) - friction * std::cos(0.6));
      EXPECT_NEAR(slide(incline, 0.0, 1.0), expected, 0.01 * expected) << friction << " " << static_cast<int>(type);
    }
  }
}

// Nothing damps; the pad is a plane at this height (m).
simulation::SceneParams sheetOverPad(Type type, double height) {
  simulation::SceneParams p;
  p.sleep.mode = simulation::Sleep::kNever;
  p.accuracy.estimate = false;
  p.integrator.type = type;
  tool::ToolParams plane = ball(0.1, Vec3(0.0, 0.0, height), Vec3::Zero());
  plane.shape.kind = geometry::Solid::Kind::kPlane;
  plane.path.resize(1);
  plane.friction = 2.0;
  p.tools = {plane};
  return p;
}

// An undamped sheet is laid on a soft pad and pushed along it: it sways on the pad's tangential springs. What they hold while it
// comes to a stop counts, and comes back.
TEST(FrictionLoad, ASheetSwaysOnASoftPad) {
  for (const Type type : {Type::kVerlet, Type::kImplicit}) {
    simulation::SceneParams p = sheetOverPad(type, 0.0);
    p.material.young_modulus = 1.5e7;
    p.material.thickness = 0.003;
    p.integrator.time_step = 0.006;
    p.gravity = Vec3(8.6, 0.0, -4.8);
    p.contact.compliance = 1e-3;
    simulation::Simulation s(p, sheetCloud(10));
    double lowest = 0.0, rise = 0.0, slowest = 1.0, swing = 0.0;  // J
    for (int k = 0; k < 120; ++k) {
      const simulation::StepOutcome outcome = s.step();
      ASSERT_TRUE(outcome.ok) << outcome.problem;
      const double kinetic = s.statistics().kinetic_energy, energy = kinetic + s.statistics().potential_energy;
      lowest = std::min(lowest, energy);
      rise = std::max(rise, energy - lowest);
      if (k > 20) slowest = std::min(slowest, kinetic);
      swing = std::max(swing, kinetic - slowest);
    }
    EXPECT_GT(swing, 0.03) << static_cast<int>(type);
    EXPECT_LT(rise, 0.02 * swing) << static_cast<int>(type);
  }
}

// An undamped sheet falls on a soft pad aslant, slides, sticks and leaves it again.
TEST(FrictionLoad, ASheetThatFallsOnASoftPadGainsNoEnergy) {
  for (const Type type : {Type::kVerlet, Type::kImplicit}) {
    simulation::SceneParams p = sheetOverPad(type, -1e-3);
    p.material.young_modulus = 1.5e5;
    p.material.thickness = 0.004;
    p.integrator.time_step = 5e-4;
    p.gravity = Vec3(4.0, 0.0, -9.0);
    p.contact.compliance = 5e-6;
    simulation::CloudParams sheet;
    sheet.shape = simulation::CloudParams::Shape::kSheet;
    sheet.points = 100;
    sheet.size = Vec2(0.5, 0.5);
    simulation::Simulation s(p, io::makeShape(sheet));
    EnergyRise energy(s);
    for (int k = 0; k < 160; ++k) {
      ASSERT_TRUE(s.step().ok);
      energy.look(s);
    }
    EXPECT_GT(energy.fastest(), 5e-3);
    EXPECT_LT(energy.rise(), 1e-6 * energy.fastest()) << static_cast<int>(type);
  }
}

TEST(FrictionLoad, WhatSlidesHasTheKineticCoefficient) {
  Incline incline;
  incline.friction = 1.0;
  incline.kinetic = 0.2;
  incline.angle = std::atan(0.25);  // between both: it stays where it is
  EXPECT_LT(slide(incline, 0.5, 1.0), 1e-6);
  Incline laid = incline;  // also if nothing presses on the plane at first
  laid.rests = 0.0;
  for (const double damping : {0.0, kDamping}) {
    laid.damping = damping;
    EXPECT_LT(slide(laid, 0.0, 1.0), 1e-4) << damping;
  }
  incline.angle = std::atan(1.2);
  incline.damping = 0.0;
  const double expected = 0.5 * 9.81 * (std::sin(incline.angle) - 0.2 * std::cos(incline.angle));
  EXPECT_NEAR(slide(incline, 0.0, 1.0), expected, 0.01 * expected);
}

TEST(FrictionLoad, AForkGoesOnFromWherePointsStick) {
  Incline incline;
  incline.angle = std::atan(0.5);
  simulation::Simulation s = incline.make();
  run(s, 30);
  simulation::Simulation fork = s.fork();
  const simulation::Snapshot snapshot = s.snapshot();
  run(s, 20);
  run(fork, 20);
  EXPECT_EQ(s.stateHash(), fork.stateHash());
  fork.restore(snapshot);
  run(fork, 20);
  EXPECT_EQ(s.stateHash(), fork.stateHash());
}

TEST(FrictionLoad, AToolCarriesWhatLiesOnItAsItMoves) {
  Incline incline;
  incline.damping = 0.0;
  simulation::Simulation s = incline.make();
  const double before = meanPlace(s);
  tool::ToolParams plane = s.tools()[0];
  plane.path = {{s.time(), Vec3::Zero(), Vec4(0.0, 0.0, 0.0, 1.0)},
                {s.time() + 1.0, Vec3(0.3, 0.0, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)}};
  s.moveTool(plane.id, plane.path);
  run(s, 120);
  EXPECT_NEAR(meanPlace(s) - before, 0.3, 2e-3);  // it starts and stops at once, and slips for a short time
}

// A sheet is thrown on a box with friction. The result must not depend on the frame in which box and sheet are described.
TEST(FrictionLoad, ImplicitStepsOnACarriedToolAreThoseOnAToolAtRest) {
  const double end = 0.3;
  const auto throwSheet = [&](const Vec3& carried, double step) {
    simulation::SceneParams p;
    p.simplification.method = cloud::SimplificationMethod::kNone;
    p.accuracy.estimate = false;
    p.contact.self = false;
    p.sleep.mode = simulation::Sleep::kNever;
    p.material.young_modulus = 1e5;
    p.material.thickness = 1e-3;
    p.material.density = 300.0;
    p.integrator.type = Type::kImplicit;
    p.integrator.time_step = step;
    p.integrator.tolerance = 1e-9;
    tool::ToolParams box = ball(0.05, Vec3(0.0, 0.0, -0.05), Vec3(0.0, 0.0, -0.05) + carried);
    box.shape.kind = geometry::Solid::Kind::kBox;
    box.shape.size = Vec3(0.5, 0.5, 0.1);
    box.friction = 0.5;
    p.tools = {box};
    Points points = makeSheet(9, 9, 0.3, 0.3, 0.2).points;
    for (Vec3& x : points) x += Vec3(-0.15, 0.0, 0.03);
    simulation::Simulation s(p, asCloud(points));
    model::State state = s.state();
    for (Vec3& v : state.velocities) v = carried + Vec3(0.3, 0.0, -0.2);
    s.setState(state);
    for (int k = 0; k < std::lround(end / step); ++k) EXPECT_TRUE(s.step().ok);
    Points places = s.state().positions;
    for (Vec3& x : places) x -= end * carried;
    return places;
  };
  for (const double step : {0.005, 0.02}) {
    const Points resting = throwSheet(Vec3::Zero(), step);
    for (const Vec3& carried : {Vec3(2.0, 0.0, 0.0), Vec3(-1.0, 1.0, 1.0)}) {
      const Points places = throwSheet(carried, step);
      double apart = 0.0;
      for (std::size_t i = 0; i < places.size(); ++i) apart = std::max(apart, (places[i] - resting[i]).norm());
      EXPECT_LT(apart, 1e-4) << step << " " << carried.transpose();
    }
  }
}

// Also tools that only pass by, and one that comes near when the sub-steps have long been chosen.
TEST(FrictionLoad, OnlyToolsThatMayTouchShortenTheSubsteps) {
  const auto countSubsteps = [](const std::vector<tool::ToolParams>& tools, int steps) {
    simulation::SceneParams p = hangingSheet();
    p.accuracy.estimate = false;
    p.integrator.type = Type::kVerlet;
    p.material.damping = 1.0;
    p.tools = tools;
    simulation::Simulation s(p, sheetCloud());
    for (int k = 0; k < steps; ++k) EXPECT_TRUE(s.step().ok);
    return s.statistics().substeps;
  };
  std::vector<tool::ToolParams> far;
  for (int k = 0; k < 8; ++k) {
    const Vec3 place(0.5 * k, 5.0, 0.0);
    far.push_back(ball(0.1, place, place + Vec3(0.2, 0.0, 0.0)));
    far.back().id += std::to_string(k);
    far.back().friction = 0.5;
  }
  const auto free = countSubsteps({}, 4);
  EXPECT_EQ(countSubsteps(far, 4), free);
  for (tool::ToolParams& tool : far) tool.path = {{0.0, Vec3(0.5, 0.5, 0.3), Vec4(0.0, 0.0, 0.0, 1.0)}};
  EXPECT_GT(countSubsteps(far, 20), free);
}

}  // namespace
}  // namespace deformable_surface::test
