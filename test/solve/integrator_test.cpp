#include "deformable_surface/solve/integrator.h"
#include "deformable_surface/solve/stable_step.h"
#include "oscillators.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>

namespace deformable_surface::test {
namespace {

using solve::IntegratorParams;
using solve::IntegratorType;
using solve::System;

constexpr double kNoLimit = std::numeric_limits<double>::infinity();
const std::vector<const solve::ExternalLoad*> kNoLoads;

State startAt(const Vec3& x, const Vec3& v, Index n = 1) { return {Points(n, x), Points(n, v)}; }

struct World {
  World(std::vector<double> stiffness, double mass, double viscosity = 0.0, double damping = 0.0)
      : model(std::move(stiffness), mass, viscosity), held(model.masses().size(), 0), system(model, loads, held, damping) {}

  // Runs for duration in n steps of one sub-step each.
  State run(IntegratorType type, double duration, int n, State state, const IntegratorParams& params = {}) {
    const auto integrator = solve::makeIntegrator(type, params);
    const double dt = duration / n;
    for (int k = 0; k < n; ++k) last = integrator->advance(system, k * dt, dt, kNoLimit, state);
    return state;
  }

  Oscillators model;
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held;
  System system;
  solve::SolveReport last;
};

// Slope of log(error) over log(step) of x'' = -x from two step counts.
double measureOrder(IntegratorType type) {
  World world({1.0}, 1.0);
  IntegratorParams params;
  params.tolerance = 1e-12;
  const auto error = [&](int n) {
    const State end = world.run(type, 2.0, n, startAt(Vec3::UnitX(), Vec3::Zero()), params);
    return (end.positions[0] - std::cos(2.0) * Vec3::UnitX()).norm();
  };
  return std::log2(error(100) / error(200));
}

TEST(Integrators, ShowTheirOrder) {
  EXPECT_NEAR(measureOrder(IntegratorType::kExplicitEuler), 1.0, 0.1);
  EXPECT_NEAR(measureOrder(IntegratorType::kSymplecticEuler), 1.0, 0.1);
  EXPECT_NEAR(measureOrder(IntegratorType::kImplicit), 2.0, 0.1);
  EXPECT_NEAR(measureOrder(IntegratorType::kVerlet), 2.0, 0.1);
}

TEST(Integrators, VerletKeepsItsOrderWithDampingByMassAndByVelocity) {
  // x'' = -x - (c + b) x' with c by mass and b viscous.
  const double c = 0.3, b = 0.2, decay = 0.5 * (c + b), w = std::sqrt(1.0 - decay * decay);
  const auto error = [&](int n) {
    World world({1.0}, 1.0, b, c);
    const State end = world.run(IntegratorType::kVerlet, 2.0, n, startAt(Vec3::UnitX(), Vec3::Zero()));
    const double exact = std::exp(-2.0 * decay) * (std::cos(2.0 * w) + decay / w * std::sin(2.0 * w));
    return std::abs(end.positions[0].x() - exact);
  };
  EXPECT_NEAR(std::log2(error(100) / error(200)), 2.0, 0.15);
}

// Steps of 0.95 of the stable one without dampers. At velocities predicted with the forces before, as for viscosity, it would be
// 0.9, 0.62 and 0.41 of that for these rates.
TEST(Integrators, VerletIsStableWithDampersThatAreSplitOff) {
  constexpr double dt = 1.9;
  for (const double slow : {0.0, 0.5})  // N/m
    for (const double rate : {0.1, 0.5, 1.0}) {
      const SlowerOscillators model({1.0 - slow, 0.1, 0.3}, slow, 1.0);
      const SplitDamper damper(rate);
      const std::vector<const solve::ExternalLoad*> loads{&damper};
      const std::vector<char> held(3, 0);
      const System system(model, loads, held, 0.0);
      const auto verlet = solve::makeIntegrator(IntegratorType::kVerlet, {});
      State state = startAt(Vec3(1.0, -2.0, 0.5), Vec3(0.3, 0.1, -1.0), 3);
      const auto energy = [&] { return system.potentialEnergy(0.0, state) + system.kineticEnergy(state); };
      double before = 20.0 * energy();
      for (int k = 0; k < 5; ++k) {
        verlet->advance(system, 0.0, 40 * dt, dt / 0.5, state);
        EXPECT_LT(energy(), 0.5 * before) << rate << " " << slow;
        before = energy();
      }
    }
}

TEST(Integrators, VerletEvaluatesTheModelOnceAStepWhileNothingElseMovesThePoints) {
  for (double viscosity : {0.0, 0.1}) {
    World world({1.0}, 1.0, viscosity);
    world.run(IntegratorType::kVerlet, 1.0, 10, startAt(Vec3::UnitX(), Vec3::Zero()));
    EXPECT_EQ(world.model.evaluations, viscosity > 0.0 ? 20 : 11);
  }
}

TEST(Integrators, VerletNoticesThatPointsWereMovedOrLoadsChangedBetweenSteps) {
  World world({1.0}, 1.0);
  const ConstantField wind(world.model.masses(), Vec3::UnitY());
  const auto used = solve::makeIntegrator(IntegratorType::kVerlet, {});
  State state = startAt(Vec3::UnitX(), Vec3::Zero());
  const auto compareWithFresh = [&] {
    State expected = state;
    solve::makeIntegrator(IntegratorType::kVerlet, {})->advance(world.system, 0.0, 0.1, kNoLimit, expected);
    used->advance(world.system, 0.0, 0.1, kNoLimit, state);
    EXPECT_EQ(state.positions[0], expected.positions[0]);
    EXPECT_EQ(state.velocities[0], expected.velocities[0]);
  };
  compareWithFresh();
  compareWithFresh();
  state.positions[0].z() += 1.0;
  compareWithFresh();
  world.loads.push_back(&wind);
  compareWithFresh();
  world.loads.clear();
  compareWithFresh();
}

// The state after `duration` in n steps of eight sub-steps and two outer steps each, and the number of evaluations.
State runInOuterSteps(const SlowerOscillators& model, double damping, double duration, int n, State state) {
  const std::vector<char> held(model.masses().size(), 0);
  const System system(model, kNoLoads, held, damping);
  const auto verlet = solve::makeIntegrator(IntegratorType::kVerlet, {});
  const double dt = duration / n;
  verlet->setSlowStep(kNoLimit, 4);
  for (int k = 0; k < n; ++k) verlet->advance(system, k * dt, dt, 0.25 * dt, state);
  return state;
}

TEST(Integrators, VerletKeepsItsOrderWithSlowForcesInOuterStepsAndBothKindsOfDamping) {
  // x'' = -(9 + 1) x - (c + b) x' with c by mass and b viscous. The term with 1 is slow.
  const double c = 0.3, b = 0.2, decay = 0.5 * (c + b), w = std::sqrt(10.0 - decay * decay);
  const SlowerOscillators model({9.0}, 1.0, 1.0, b);
  const auto error = [&](int n) {
    const State end = runInOuterSteps(model, c, 2.0, n, startAt(Vec3::UnitX(), Vec3::Zero()));
    const double exact = std::exp(-2.0 * decay) * (std::cos(2.0 * w) + decay / w * std::sin(2.0 * w));
    return std::abs(end.positions[0].x() - exact);
  };
  EXPECT_NEAR(std::log2(error(20) / error(40)), 2.0, 0.15);
}

TEST(Integrators, VerletsOuterStepsEvaluateSlowForcesOnceAndDoNotDrift) {
  const SlowerOscillators model({9.0}, 1.0, 1.0);
  const int steps = 5000;
  const State end = runInOuterSteps(model, 0.0, 0.2 * steps, steps, startAt(Vec3::UnitX(), Vec3::Zero()));
  EXPECT_EQ(model.evaluations, 8 * steps + 1);
  EXPECT_EQ(model.slow_evaluations, 2 * steps + 1);
  // The conserved quantity of an outer step of 0.1 s differs from the energy by about (0.1 s)^2 / 4 of the slow part.
  EXPECT_NEAR(0.5 * (10.0 * end.positions[0].squaredNorm() + end.velocities[0].squaredNorm()), 5.0, 0.01);
}

TEST(Integrators, VerletsForcesKeptFromStepToStepGiveTheBitsOfAFreshStart) {
  const SlowerOscillators model({9.0}, 1.0, 1.0);
  const std::vector<char> held{0};
  const System system(model, kNoLoads, held, 0.1);
  const auto used = solve::makeIntegrator(IntegratorType::kVerlet, {});
  State state = startAt(Vec3::UnitX(), Vec3::UnitY());
  for (Index most_inner : {4, 4, 1, 1, 3}) {
    const auto fresh = solve::makeIntegrator(IntegratorType::kVerlet, {});
    State expected = state;
    for (const auto* integrator : {&used, &fresh}) {
      (*integrator)->setSlowStep(kNoLimit, most_inner);
      (*integrator)->advance(system, 0.0, 0.2, 0.05, integrator == &used ? state : expected);
    }
    EXPECT_EQ(state.positions[0], expected.positions[0]);
    EXPECT_EQ(state.velocities[0], expected.velocities[0]);
  }
}

TEST(Integrators, FreeFallIsExactWithVerletAndLateByHalfAStepWithFirstOrderMethods) {
  for (const auto& [type, error] :
       {std::pair{IntegratorType::kVerlet, 0.0}, std::pair{IntegratorType::kSymplecticEuler, -0.5 * 9.81 / 60.0},
        std::pair{IntegratorType::kImplicit, 0.0}, std::pair{IntegratorType::kExplicitEuler, 0.5 * 9.81 / 60.0}}) {
    World world({0.0}, 2.0);
    const ConstantField gravity(world.model.masses(), Vec3(0.0, 0.0, -9.81));
    world.loads.push_back(&gravity);
    for (const double speed : {0.0, 20.0}) {  // m/s, upwards
      const State end = world.run(type, 1.0, 60, startAt(Vec3::Zero(), speed * Vec3::UnitZ()));
      EXPECT_NEAR(end.positions[0].z(), speed - 0.5 * 9.81 + error, 1e-6) << static_cast<int>(type) << " " << speed;
      EXPECT_NEAR(end.velocities[0].z(), speed - 9.81, 1e-6);
    }
  }
}

TEST(Integrators, DampingByMassIsExactInTheExplicitOnes) {
  World world({0.0}, 1.0, 0.0, 0.7);
  for (IntegratorType type : {IntegratorType::kVerlet, IntegratorType::kSymplecticEuler}) {
    const State end = world.run(type, 2.0, 3, startAt(Vec3::Zero(), Vec3::UnitX()));
    EXPECT_NEAR(end.velocities[0].x(), std::exp(-1.4), 1e-14);
  }
}

TEST(Integrators, SymplecticOnesDoNotDriftAndExplicitEulerGrows) {
  World world({1.0}, 1.0);
  const auto energyAfter = [&](IntegratorType type) {
    const State end = world.run(type, 2000.0, 20000, startAt(Vec3::UnitX(), Vec3::Zero()));
    return 0.5 * (end.positions[0].squaredNorm() + end.velocities[0].squaredNorm());
  };
  EXPECT_NEAR(energyAfter(IntegratorType::kVerlet), 0.5, 0.002);
  EXPECT_NEAR(energyAfter(IntegratorType::kSymplecticEuler), 0.5, 0.03);
  EXPECT_GT(energyAfter(IntegratorType::kExplicitEuler), 1e6);
}

TEST(Integrators, ImplicitLosesTheStatedShareOfAMode) {
  IntegratorParams params;
  params.tolerance = 1e-12;
  const double h = 0.5, gamma = 1.0 - std::sqrt(0.5);
  const std::complex<double> z(0.0, h);
  // The factor of one step on exp(i t): (1 + (1 - 2 gamma) z) / (1 - gamma z)^2.
  const double factor = std::abs((1.0 + (1.0 - 2.0 * gamma) * z) / std::pow(1.0 - gamma * z, 2));
  World world({1.0}, 1.0);
  const State end = world.run(IntegratorType::kImplicit, 10 * h, 10, startAt(Vec3::UnitX(), Vec3::Zero()), params);
  const double amplitude = std::sqrt(end.positions[0].squaredNorm() + end.velocities[0].squaredNorm());
  EXPECT_NEAR(amplitude, std::pow(factor, 10), 1e-9);
}

TEST(Integrators, ImplicitKeepsItsOrderWithDampingByMassAndByVelocity) {
  const double c = 0.3, b = 0.2, decay = 0.5 * (c + b), w = std::sqrt(1.0 - decay * decay);
  IntegratorParams params;
  params.tolerance = 1e-12;
  const auto error = [&](int n) {
    World world({1.0}, 1.0, b, c);
    const State end = world.run(IntegratorType::kImplicit, 2.0, n, startAt(Vec3::UnitX(), Vec3::Zero()), params);
    const double exact = std::exp(-2.0 * decay) * (std::cos(2.0 * w) + decay / w * std::sin(2.0 * w));
    return std::abs(end.positions[0].x() - exact);
  };
  EXPECT_NEAR(std::log2(error(100) / error(200)), 2.0, 0.15);
}

TEST(Integrators, ALooseToleranceLeavesNoStageOfAFastMotionWithoutAnIteration) {
  World world({1.0}, 1.0);
  const State start = startAt(Vec3::Zero(), 100.0 * Vec3::UnitX());
  IntegratorParams loose, tight;
  loose.tolerance = 0.1;
  tight.tolerance = 1e-12;
  const State a = world.run(IntegratorType::kImplicit, 1.0, 100, start, loose);
  const State b = world.run(IntegratorType::kImplicit, 1.0, 100, start, tight);
  EXPECT_NEAR(a.positions[0].x(), b.positions[0].x(), 1e-6);  // linear: one iteration leaves the regularisation of the matrix
}

// A spring to an anchor that moves along x at 1 m/s, on the only point.
class MovingSpring : public solve::ExternalLoad {
 public:
  void addForces(double time, const State& s, Points& forces) const override { forces[0].x() -= kStiffness * stretch(time, s); }
  double potential(double time, const State& s) const override { return 0.5 * kStiffness * stretch(time, s) * stretch(time, s); }
  bool isConservative() const override { return true; }
  double drivingPower(double time, double, const State& s) const override { return -kStiffness * stretch(time, s); }
  void addStiffness(double, const State&, double, BlockSparse& stiffness) const override {
    stiffness.add(0, 0, kStiffness * Vec3::UnitX() * Vec3::UnitX().transpose());
  }

 private:
  static constexpr double kStiffness = 4.0;
  static double stretch(double time, const State& s) { return s.positions[0].x() - time; }
};

// What the load puts in is no energy that the step has made.
TEST(Integrators, ImplicitTakesNoEnergyFromPointsThatComeToMeetALoad) {
  const MovingSpring spring;
  World world({0.0}, 1.0);
  world.loads.push_back(&spring);
  const State end = world.run(IntegratorType::kImplicit, 2.0, 100, startAt(Vec3::Zero(), -2.0 * Vec3::UnitX()));
  EXPECT_NEAR(end.positions[0].x(), 2.0 - 1.5 * std::sin(4.0), 5e-4);
}

// A wall that moves along x and pushes the only point with a spring.
class MovingWall : public solve::ExternalLoad {
 public:
  explicit MovingWall(double speed) : speed_(speed) {}
  void addForces(double time, const State& s, Points& forces) const override { forces[0].x() += kStiffness * depth(time, s); }
  double potential(double time, const State& s) const override { return 0.5 * kStiffness * depth(time, s) * depth(time, s); }
  bool isConservative() const override { return true; }
  double drivingPower(double time, double, const State& s) const override { return kStiffness * depth(time, s) * speed_; }
  void addStiffness(double time, const State& s, double, BlockSparse& stiffness) const override {
    stiffness.add(0, 0, (depth(time, s) > 0.0 ? kStiffness : 0.0) * Vec3::UnitX() * Vec3::UnitX().transpose());
  }

 private:
  static constexpr double kStiffness = 1e4;
  double depth(double time, const State& s) const { return std::max(0.0, speed_ * time - s.positions[0].x()); }

  double speed_;  // m/s
};

// A moving wall may seem to do more work than it does: points once left it at up to 1.3 times the speed of approach.
TEST(Integrators, ImplicitBouncesOffAMovingWallAreThoseOffAWallAtRest) {
  const MovingWall moving(1.0), resting(0.0);
  for (const double step : {1e-4, 1e-3, 3e-3, 0.01, 0.02, 0.05}) {
    for (const double gap : {0.0102, 0.0171, 0.0303}) {
      const int n = static_cast<int>(std::lround(0.3 / step));
      World pushed({0.0}, 1.0), thrown({0.0}, 1.0);
      pushed.loads.push_back(&moving);
      thrown.loads.push_back(&resting);
      const State a = pushed.run(IntegratorType::kImplicit, n * step, n, startAt(gap * Vec3::UnitX(), Vec3::Zero()));
      const State b = thrown.run(IntegratorType::kImplicit, n * step, n, startAt(gap * Vec3::UnitX(), -Vec3::UnitX()));
      EXPECT_NEAR(a.velocities[0].x() - 1.0, b.velocities[0].x(), 1e-5) << step << " " << gap;
      EXPECT_LE(b.velocities[0].x(), 1.0 + 1e-9) << step << " " << gap;
    }
  }
}

TEST(Integrators, ImplicitIsStableAtEveryStep) {
  for (double h : {1e-3, 1.0, 1e3, 1e6}) {
    World world({1.0, 1e6}, 1.0);
    const State end = world.run(IntegratorType::kImplicit, 5 * h, 5, startAt(Vec3::UnitX(), Vec3::UnitY(), 2));
    EXPECT_TRUE(world.last.converged);
    EXPECT_LE(end.positions[0].norm(), 1.5);
  }
}

TEST(Integrators, StaticFindsTheEquilibriumAndStops) {
  World world({10.0, 1000.0}, 2.0);
  const ConstantField gravity(world.model.masses(), Vec3(0.0, 0.0, -9.81));
  world.loads.push_back(&gravity);
  const State end = world.run(IntegratorType::kStatic, 0.01, 1, startAt(Vec3(1.0, 2.0, 3.0), Vec3::UnitX(), 2));
  EXPECT_TRUE(world.last.converged);
  EXPECT_NEAR(end.positions[0].z(), -2.0 * 9.81 / 10.0, 1e-5);
  EXPECT_NEAR(end.positions[1].z(), -2.0 * 9.81 / 1000.0, 1e-5);
  EXPECT_EQ(end.velocities[0], Vec3::Zero());
}

TEST(Integrators, HeldPointsDoNotMove) {
  for (IntegratorType type : {IntegratorType::kVerlet, IntegratorType::kSymplecticEuler, IntegratorType::kExplicitEuler,
                              IntegratorType::kImplicit, IntegratorType::kStatic}) {
    World world({1.0, 1.0}, 1.0);
    world.held[1] = 1;
    const State end = world.run(type, 0.5, 5, startAt(Vec3::UnitX(), Vec3::Zero(), 2));
    EXPECT_EQ(end.positions[1], Vec3(Vec3::UnitX()));
    EXPECT_NE(end.positions[0], Vec3(Vec3::UnitX()));
  }
}

TEST(Integrators, SayWhenTheStateIsNoLongerFinite) {
  World world({1.0}, 1.0);
  for (IntegratorType type : {IntegratorType::kVerlet, IntegratorType::kSymplecticEuler, IntegratorType::kExplicitEuler}) {
    world.run(type, 1.0, 1, startAt(Vec3(std::nan(""), 0.0, 0.0), Vec3::Zero()));
    EXPECT_FALSE(world.last.finite);
  }
}

TEST(Integrators, SubstepsFillTheStepAndStayUnderTheStableOne) {
  EXPECT_EQ(solve::countSubsteps(0.01, kNoLimit), 1);
  EXPECT_EQ(solve::countSubsteps(0.01, 0.01), 2);
  EXPECT_EQ(solve::countSubsteps(0.01, 0.001), 20);
  EXPECT_EQ(solve::countSubsteps(0.01, 0.0), 2000000000);
}

TEST(Integrators, OuterStepsStayUnderTheStableOneOfTheSlowForces) {
  const auto expectCut = [](double max_slow_step, Index most_inner, Index outer, Index inner) {
    const solve::Substeps cut = solve::chooseSubsteps(0.016, 0.002, max_slow_step, most_inner);  // 16 sub-steps
    EXPECT_EQ(cut.outer, outer);
    EXPECT_EQ(cut.inner, inner);
  };
  expectCut(kNoLimit, 1, 16, 1);
  expectCut(kNoLimit, 8, 2, 8);
  expectCut(kNoLimit, 5, 4, 4);  // as five would need 20 sub-steps
  expectCut(0.008001, 8, 4, 4);
  expectCut(0.0039, 8, 16, 1);  // forces marked as slow that are not slow
}

TEST(StableStep, IsTwoOverTheHighestFrequency) {
  World world({1.0, 40.0, 900.0, 25.0}, 1.0);
  solve::StableStep stable;
  const State state = startAt(Vec3::Zero(), Vec3::Zero(), 4);
  EXPECT_NEAR(stable.estimate(0.0, state, world.system), 2.0 / 30.0, 1e-6);
  world.held[2] = 1;
  EXPECT_NEAR(stable.estimate(0.0, state, world.system), 2.0 / std::sqrt(40.0), 1e-6);
}

TEST(StableStep, ShrinksWithViscousDamping) {
  World world({100.0}, 1.0, 6.0);
  solve::StableStep stable;
  const double z = 0.6;
  EXPECT_NEAR(stable.estimate(0.0, startAt(Vec3::Zero(), Vec3::Zero()), world.system), 0.2 * (std::sqrt(1.0 + z * z) - z), 1e-9);
}

TEST(StableStep, VerletIsStableBelowItAndNotAbove) {
  for (double viscosity : {0.0, 6.0}) {
    World world({100.0}, 1.0, viscosity);
    solve::StableStep stable;
    const double limit = stable.estimate(0.0, startAt(Vec3::Zero(), Vec3::Zero()), world.system);
    EXPECT_LT(
        world.run(IntegratorType::kVerlet, 2000 * 0.98 * limit, 2000, startAt(Vec3::UnitX(), Vec3::Zero())).positions[0].norm(),
        20.0);
    EXPECT_GT(
        world.run(IntegratorType::kVerlet, 100 * 1.6 * limit, 100, startAt(Vec3::UnitX(), Vec3::Zero())).positions[0].norm(),
        1e3);
  }
}

TEST(StableStep, OfAFreeBodyIsUnlimited) {
  World world({0.0, 0.0}, 1.0);
  solve::StableStep stable;
  EXPECT_EQ(stable.estimate(0.0, startAt(Vec3::Zero(), Vec3::Zero(), 2), world.system), kNoLimit);
}

// The sub-steps of one step: each takes the damping from a velocity that is predicted with the acceleration of the one before.
TEST(StableStep, IsExactForSubstepsWithDamping) {
  for (const double viscosity : {0.0, 1.0, 6.0, 30.0}) {
    World world({100.0}, 1.0, viscosity);
    const double limit = solve::StableStep().estimate(0.0, startAt(Vec3::Zero(), Vec3::Zero()), world.system);
    const auto run = [&](double share) {
      State state = startAt(Vec3::UnitX(), Vec3::Zero());
      const double dt = share * limit, unsafe = 2.0 * dt * (1.0 + 1e-9);  // Verlet takes half of what it is given
      const auto verlet = solve::makeIntegrator(IntegratorType::kVerlet, {});
      EXPECT_EQ(verlet->advance(world.system, 0.0, 1000.0 * dt, unsafe, state).substeps, 1000);
      return state.positions[0].norm();
    };
    EXPECT_LT(run(0.99), 10.0) << viscosity;
    EXPECT_GT(run(1.01), 1e3) << viscosity;
  }
}

// Free flight has no other energy; on a spring Verlet's account oscillates by (w h)^2 / 8 of it.
TEST(VelocityVerlet, TellsWhatDampingTookOut) {
  for (double stiffness : {0.0, 400.0}) {
    const Oscillators model({stiffness}, 2.0);
    const std::vector<const solve::ExternalLoad*> loads;
    const std::vector<char> held{0};
    const solve::System system(model, loads, held, 3.0);
    State state{{Vec3(0.1, 0.0, 0.0)}, {Vec3(0.0, 2.0, -1.0)}};
    const auto energy = [&] { return system.kineticEnergy(state) + system.elasticEnergy(state); };
    const double before = energy();
    const auto verlet = solve::makeIntegrator(solve::IntegratorType::kVerlet, {});
    const solve::SolveReport report = verlet->advance(system, 0.0, 0.5, 0.002, state);
    const double angle = std::sqrt(stiffness / 2.0) * 0.5 / report.substeps;
    EXPECT_GT(report.dissipated, 0.5 * before);
    EXPECT_NEAR(before - energy(), report.dissipated, (1e-14 + angle * angle / 8.0) * before) << stiffness;
  }
}

// Keeps the first two points at their distance; they also move along x by a given way, to and fro in turn.
class Clamp : public solve::MotionLimit {
 public:
  explicit Clamp(double way = 0.0, std::vector<Index> parts = {0, 0, 0}) : way_(way), parts_(std::move(parts)) {}
  const std::vector<Index>& limit(const Points& before, Points& after, bool) const override {
    const Vec3 mean = 0.5 * (after[0] - before[0] + after[1] - before[1]), aside = (++calls_ % 2 ? way_ : -way_) * Vec3::UnitX();
    after[0] = before[0] + mean + aside;
    after[1] = before[1] + mean - aside;
    return clamped_;
  }
  const std::vector<Index>& parts() const override { return parts_; }

 private:
  const double way_;
  const std::vector<Index> clamped_{0, 1}, parts_;
  mutable int calls_ = 0;
};

// The speed, at the end, of a point that flies freely at 1 m/s beside two that springs press together.
double flyBesideAClamp(double damping, const Clamp& clamp) {
  World world({1e6, 1e6, 0.0}, 1.0, 0.0, damping);
  world.system.setMotionLimit(&clamp);
  State state{{Vec3::UnitX(), -Vec3::UnitX(), Vec3::Zero()}, {Vec3::Zero(), Vec3::Zero(), Vec3::UnitZ()}};
  solve::makeIntegrator(IntegratorType::kVerlet, {})->advance(world.system, 0.0, 0.01, 0.001, state);
  return state.velocities[2].z();
}

TEST(VelocityVerlet, DampingMakesNoWorkOfLimitsThatWouldHaltOtherPoints) {
  EXPECT_NEAR(flyBesideAClamp(2.0, Clamp()), std::exp(-2.0 * 0.01), 1e-9);
}

TEST(VelocityVerlet, LimitsThatMovePointsToAndFroHaltNoOtherPoints) { EXPECT_NEAR(flyBesideAClamp(0.0, Clamp(1e-6)), 1.0, 1e-5); }

TEST(VelocityVerlet, LimitsTakeTheEnergyThatTheyMakeFromThePartsThatTheyStopAlone) {
  const Clamp among(1e-3), beside(1e-3, {0, 0, 1});
  EXPECT_LT(flyBesideAClamp(0.0, among), 0.9);
  EXPECT_EQ(flyBesideAClamp(0.0, beside), 1.0);
}

}  // namespace
}  // namespace deformable_surface::test
