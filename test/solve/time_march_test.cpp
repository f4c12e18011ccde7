// The length of sub-steps, and the number of them in which slow forces act, as the stable step and the energy account change.
#include "deformable_surface/solve/time_march.h"
#include "deformable_surface/base/interrupt.h"
#include "oscillators.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace deformable_surface::test {
namespace {

// A model with a stated stable step. A change of its stretch causes a new request.
class KnownStep : public SlowerOscillators, public model::Links {
 public:
  explicit KnownStep(double stiffness) : SlowerOscillators({stiffness}, 1e-3, 1.0) {}
  double findStableStep(const State&) const override {
    return ++num_estimates > 1 && later_step > 0.0 ? later_step : stable_step;
  }
  const model::Links* links() const override { return this; }
  const std::vector<std::pair<Index, Index>>& stretchLinks() const override { return no_links; }
  const std::vector<std::pair<Index, Index>>& bendLinks() const override { return no_links; }
  double maxStretch(const State&) const override { return stretch += growth; }
  void computePointStrain(const State& s, std::vector<double>& strain) const override { strain.assign(s.positions.size(), 0.0); }

  void change(double step) {
    stable_step = step;
    stretch += 1.0;
  }
  double stable_step = 0.01, growth = 0.0;  // growth: of the stretch from one look at it to the next
  double later_step = 0.0;                  // stable step from the second estimate on; 0: the same
  mutable double stretch = 0.0;
  mutable int num_estimates = 0;
  std::vector<std::pair<Index, Index>> no_links;
};

struct March {
  explicit March(double stiffness, double damping = 0.0)
      : model(stiffness), system(model, loads, held, damping), march(system, model, params) {}

  Index countSubsteps() { return march.step(0.0, state).report.substeps; }

  KnownStep model;
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held{0};
  solve::System system;
  solve::IntegratorParams params;
  solve::TimeMarch march;
  State state{{Vec3(1.0, 0.0, 0.0)}, {Vec3::Zero()}};
};

TEST(TimeMarch, ShortensSubstepsAtOnceAndLengthensThemOnlyWhenTheyCouldLongHaveBeenLonger) {
  March m(1.0);
  EXPECT_EQ(m.countSubsteps(), 2);
  m.model.change(0.002);
  EXPECT_EQ(m.countSubsteps(), 6);
  for (int swing = 0; swing < 3; ++swing) {
    m.model.change(0.01);
    for (int k = 0; k < 99; ++k) ASSERT_EQ(m.countSubsteps(), 6) << k;
    m.model.change(0.00235);  // with which five would suffice, but that is not worth a change
    for (int k = 0; k < 101; ++k) ASSERT_EQ(m.countSubsteps(), 6) << k;
  }
  m.model.change(0.01);
  for (int k = 0; k < 99; ++k) m.countSubsteps();
  EXPECT_EQ(m.countSubsteps(), 2);
  m.model.change(0.002);
  m.march.restart();
  m.countSubsteps();
  m.model.change(0.01);
  m.march.restart();
  EXPECT_EQ(m.countSubsteps(), 2);
}

TEST(TimeMarch, EstimatesTheStableStepAgainOnceTheStretchHasLongBeenLess) {
  March m(1.0);
  m.model.stretch = 0.5;
  m.model.stable_step = 0.002;
  EXPECT_EQ(m.countSubsteps(), 6);
  m.model.stable_step = 0.01;
  for (int swing = 0; swing < 3; ++swing) {
    m.model.stretch = 0.1;
    for (int k = 0; k < 99; ++k) ASSERT_EQ(m.countSubsteps(), 6) << k;
    m.model.stretch = 0.5;
    ASSERT_EQ(m.countSubsteps(), 6);
  }
  EXPECT_EQ(m.model.num_estimates, 1);
  m.model.stretch = 0.1;
  for (int k = 0; k < 99; ++k) m.countSubsteps();
  EXPECT_EQ(m.countSubsteps(), 2);
  EXPECT_EQ(m.model.num_estimates, 2);
}

// Names the point as stopped, though it leaves its motion as it is.
class Stopper : public solve::MotionLimit {
 public:
  const std::vector<Index>& limit(const Points&, Points&, bool) const override { return stopped; }
  const std::vector<Index>& parts() const override { return parts_; }

  std::vector<Index> stopped;

 private:
  const std::vector<Index> parts_{0};
};

TEST(TimeMarch, SubstepsAreShorterAfterAStepInWhichManyPointsWereStopped) {
  March m(1.0);
  m.params.time_step = 0.1;
  Stopper stopper;
  m.system.setMotionLimit(&stopper);
  const Index free = m.countSubsteps();
  stopper.stopped = {0};
  EXPECT_EQ(m.countSubsteps(), free);
  const Index jammed = m.countSubsteps();
  EXPECT_GT(jammed, free);
  const solve::TimeMarch::Memory memory = m.march.memory();
  m.march.setMemory(memory);
  EXPECT_EQ(m.countSubsteps(), jammed);
  stopper.stopped.clear();
  EXPECT_EQ(m.countSubsteps(), jammed);
  EXPECT_EQ(m.countSubsteps(), free);
}

// Springs to the places of the points, like contacts that begin and end.
class Contacts : public solve::ExternalLoad {
 public:
  void addForces(double, const State&, Points&) const override {}
  double estimateWork(double, double, const State&, const State&) const override { return 0.0; }
  void addRowBounds(double, const State&, std::vector<double>& k, std::vector<double>&) const override { k[0] += stiffness; }

  double stiffness = 0.0;  // N/m
};

TEST(TimeMarch, AContactThatComesShortensSubstepsThoughNothingIsStretched) {
  March m(1.0);
  Contacts contacts;
  m.loads.push_back(&contacts);
  EXPECT_EQ(m.countSubsteps(), 2);
  EXPECT_EQ(m.model.num_estimates, 1);
  contacts.stiffness = 3.0 * 4.0 / (0.01 * 0.01);  // thrice the square of the model's highest frequency, of a mass of 1 kg
  EXPECT_EQ(m.countSubsteps(), 3);
  EXPECT_EQ(m.model.num_estimates, 2);
  contacts.stiffness *= 1.05;
  m.countSubsteps();
  EXPECT_EQ(m.model.num_estimates, 2);
}

TEST(TimeMarch, AStableStepThatWasFoundBeforehandHoldsForAStateThatAPartBroughtOn) {
  March m(1.0);
  m.march.prepare(0.0, m.state);
  EXPECT_EQ(m.countSubsteps(), 2);
  m.march.resume();
  EXPECT_EQ(m.countSubsteps(), 2);
  EXPECT_EQ(m.model.num_estimates, 1);
  // Searched where it would have been without the part.
  m.model.change(0.002);
  m.march.resume();
  EXPECT_EQ(m.countSubsteps(), 6);
  EXPECT_EQ(m.model.num_estimates, 2);
  m.march.forcesChanged();
  m.march.resume();
  m.countSubsteps();
  EXPECT_EQ(m.model.num_estimates, 3);
}

TEST(TimeMarch, SlowForcesActInOuterStepsWhileTheEnergyIsCalm) {
  March m(1.0);
  m.model.change(0.001);
  EXPECT_EQ(m.countSubsteps(), 12);
  EXPECT_EQ(m.model.evaluations, 13);
  EXPECT_EQ(m.model.slow_evaluations, 3);
}

TEST(TimeMarch, SlowForcesActInOuterStepsUnderDampingByMassToo) {
  March m(1.0, 5.0);
  m.model.change(0.001);
  m.countSubsteps();
  EXPECT_EQ(m.model.slow_evaluations, 3);
}

// A force whose work is not known, as of friction. It would hide what resonances make.
class Rubbing : public solve::ExternalLoad {
 public:
  void addForces(double, const State&, Points&) const override {}
  double estimateWork(double, double, const State&, const State&) const override { return 0.0; }
};

TEST(TimeMarch, SlowForcesActInEverySubstepBesideForcesThatDissipate) {
  March m(1.0);
  const Rubbing rubbing;
  m.loads.push_back(&rubbing);
  m.model.change(0.001);
  const Index substeps = m.countSubsteps();
  EXPECT_GE(m.model.slow_evaluations, static_cast<int>(substeps));
}

TEST(TimeMarch, SlowForcesActInEverySubstepWhereTheSurfaceSettlesSoThatItReachesItsBalance) {
  March m(400.0, 40.0);
  const ConstantField gravity(m.model.masses(), Vec3(0.0, 0.0, -9.81));
  m.loads.push_back(&gravity);
  m.model.change(0.001);
  for (int k = 0; k < 300; ++k) m.countSubsteps();
  const int before = m.model.slow_evaluations;
  EXPECT_EQ(m.countSubsteps(), 12);
  EXPECT_EQ(m.model.slow_evaluations - before, 12);
  EXPECT_NEAR(m.state.positions[0].z(), -9.81 / 400.001, 1e-12);
}

TEST(TimeMarch, SlowForcesActInEverySubstepWhereTheEnergyIsNotCalm) {
  // w h = 0.3: the energy of Verlet oscillates by some hundredths.
  March m(300.0 * 300.0);
  m.model.change(0.001);
  for (int k = 0; k < 20; ++k) m.countSubsteps();
  const int before = m.model.slow_evaluations;
  EXPECT_EQ(m.countSubsteps(), 20);
  EXPECT_EQ(m.model.slow_evaluations - before, 20);
}

// No force, but it requests the end of the step after so many calls.
class Interrupter : public solve::ExternalLoad {
 public:
  void addForces(double, const State&, Points&) const override {
    if (--left == 0) interrupt = true;
  }
  bool isConservative() const override { return true; }
  mutable int left = 0;
  mutable std::atomic<bool> interrupt{false};
};

TEST(TimeMarch, AnInterruptedStepEndsEarlyAndKeepsTheStateAndLaterStepsAreTheSame) {
  Interrupter load;
  March m(1.0), undisturbed(1.0);
  m.loads = {&load};
  m.march.setInterrupt(&load.interrupt);
  // Ten thousand sub-steps and more.
  m.params.type = undisturbed.params.type = solve::IntegratorType::kVerlet;
  m.model.change(1e-6);
  undisturbed.model.change(1e-6);
  EXPECT_TRUE(m.march.step(0.0, m.state).ok);
  EXPECT_TRUE(undisturbed.march.step(0.0, undisturbed.state).ok);
  const State before = m.state;
  load.left = 100;
  const solve::TimeMarch::Outcome outcome = m.march.step(0.01, m.state);
  EXPECT_FALSE(outcome.ok);
  EXPECT_EQ(outcome.failure.kind, solve::StepFailure::Kind::kInterrupted);
  EXPECT_GT(load.left, -5000);  // the number of requests afterwards
  EXPECT_EQ(m.state.positions, before.positions);
  EXPECT_EQ(m.state.velocities, before.velocities);

  load.interrupt = false;
  EXPECT_TRUE(m.march.step(0.01, m.state).ok);
  EXPECT_TRUE(undisturbed.march.step(0.01, undisturbed.state).ok);
  EXPECT_EQ(m.state.positions, undisturbed.state.positions);
}

TEST(TimeMarch, WhatLeavesSpaceIsRefusedWithoutTheRestOfItsSubsteps) {
  for (const solve::IntegratorType type : {solve::IntegratorType::kVerlet, solve::IntegratorType::kImplicit}) {
    March m(1.0);
    m.params.type = type;
    m.model.stable_step = 1e-5;
    m.state.velocities[0] = Vec3(1e12, 0.0, 0.0);
    const solve::TimeMarch::Outcome outcome = m.march.step(0.0, m.state);
    EXPECT_FALSE(outcome.ok);
    EXPECT_EQ(outcome.failure.kind, solve::StepFailure::Kind::kLeftSpace);
    EXPECT_LT(outcome.report.substeps, 100);  // of thousands, of Verlet
    if (type == solve::IntegratorType::kImplicit) EXPECT_EQ(outcome.retried.kind, solve::StepFailure::Kind::kNone);
    EXPECT_EQ(m.state.positions[0], Vec3(1.0, 0.0, 0.0));
  }
}

TEST(TimeMarch, AStepThatBecomesTooStiffForVerletIsAFallbackAndOneThatAutoTakesImplicitlyIsNone) {
  March m(1.0);
  m.params.max_substeps = 500;
  m.model.stable_step = 2e-4;  // a hundred sub-steps
  m.model.later_step = 1e-5;   // two thousand
  m.model.growth = 0.2;
  const solve::TimeMarch::Outcome first = m.march.step(0.0, m.state);
  ASSERT_TRUE(first.ok);
  EXPECT_EQ(first.type, solve::IntegratorType::kVerlet);
  EXPECT_GT(first.report.fallbacks, 0);
  EXPECT_EQ(first.report.fallbacks, first.report.substeps);
  const solve::TimeMarch::Outcome second = m.march.step(0.01, m.state);
  ASSERT_TRUE(second.ok);
  EXPECT_EQ(second.type, solve::IntegratorType::kImplicit);
  EXPECT_TRUE(second.has_changed_type);
  EXPECT_EQ(second.report.fallbacks, 0);
}

// An implicit step of one point is the work of some eighty evaluations of its force: two matrices and what goes with them.
constexpr Index kCostOfImplicit = 80;

// How the next steps are taken first, and how often `auto` changed in them.
std::pair<std::vector<solve::IntegratorType>, int> findTypes(March& m, int steps) {
  std::vector<solve::IntegratorType> types;
  int changes = 0;
  for (int k = 0; k < steps; ++k) {
    const solve::TimeMarch::Outcome taken = m.march.step(0.01 * k, m.state);
    EXPECT_TRUE(taken.ok);
    types.push_back(taken.type);
    changes += taken.has_changed_type;
  }
  return {types, changes};
}

Index count(const std::vector<solve::IntegratorType>& types, solve::IntegratorType type) {
  return static_cast<Index>(std::count(types.begin(), types.end(), type));
}

TEST(TimeMarch, AutoReturnsToMoreSubstepsThanMaxSubstepsWhereImplicitStepsTakeFarMoreWork) {
  March m(1.0);
  const Rubbing rubbing;  // so that slow forces act in every sub-step
  m.loads.push_back(&rubbing);
  m.params.max_substeps = 10;
  m.model.stable_step = 0.02 / (kCostOfImplicit / 4);
  const auto [types, changes] = findTypes(m, 100);
  EXPECT_EQ(types.front(), solve::IntegratorType::kImplicit);
  EXPECT_GE(count(types, solve::IntegratorType::kVerlet), 90);
  EXPECT_EQ(types.back(), solve::IntegratorType::kVerlet);
  EXPECT_EQ(changes, 2);
  EXPECT_GT(m.countSubsteps(), m.params.max_substeps);
}

// Its first implicit step is given up after one of the two matrices that it needs.
TEST(TimeMarch, AutoTakesAStepByVerletOnceAnImplicitOneTurnsOutToBeFarMoreWork) {
  March m(1.0), verlet(1.0);
  m.params.max_substeps = 1;
  verlet.params.type = solve::IntegratorType::kVerlet;
  for (int k = 0; k < 100; ++k) {
    const solve::TimeMarch::Outcome taken = m.march.step(0.01 * k, m.state);
    ASSERT_TRUE(taken.ok && verlet.march.step(0.01 * k, verlet.state).ok);
    ASSERT_EQ(taken.type, solve::IntegratorType::kVerlet);
    EXPECT_EQ(taken.has_changed_type, k == 0);
    EXPECT_EQ(taken.report.fallbacks, 0);
    EXPECT_GT(taken.report.substeps, m.params.max_substeps);
    if (k == 0) {
      EXPECT_GT(m.march.memory().implicit_work, 0.25 * 0.4 * kCostOfImplicit);
      EXPECT_LT(m.march.memory().implicit_work, 0.25 * 0.6 * kCostOfImplicit);
    }
    ASSERT_EQ(m.state.positions, verlet.state.positions);
    ASSERT_EQ(m.state.velocities, verlet.state.velocities);
  }
}

TEST(TimeMarch, AutoTriesImplicitStepsAgainWhenItsKnowledgeOfTheirWorkIsOld) {
  March m(1.0);
  m.params.max_substeps = 10;
  m.model.stable_step = 0.02 / (kCostOfImplicit / 4);
  const auto [types, changes] = findTypes(m, 1000);
  EXPECT_GT(changes, 2);
  EXPECT_LE(changes, 16);
  EXPECT_LE(count(types, solve::IntegratorType::kImplicit), 40);
}

TEST(TimeMarch, AutoKeepsToImplicitStepsThatTakeLessWork) {
  March m(1.0);
  const Rubbing rubbing;  // so that slow forces act in every sub-step
  m.loads.push_back(&rubbing);
  m.params.max_substeps = 10;
  m.model.stable_step = 0.02 / (2 * kCostOfImplicit);
  const auto [types, changes] = findTypes(m, 300);
  EXPECT_EQ(count(types, solve::IntegratorType::kImplicit), 300);
  EXPECT_EQ(changes, 1);
}

// Slow forces act once in eight sub-steps there: these are a third of the work.
TEST(TimeMarch, AutoCountsSubstepsWithoutSlowForcesAsLessWork) {
  March m(1.0);
  m.params.max_substeps = 10;
  m.model.stable_step = 0.02 / (2 * kCostOfImplicit);
  const auto [types, changes] = findTypes(m, 100);
  EXPECT_GE(count(types, solve::IntegratorType::kVerlet), 80);
  EXPECT_EQ(changes, 2);
}

// Near damped contact sub-steps are shorter.
TEST(TimeMarch, AutoReturnsToVerletOnlyWhereTheSubstepsThatItTakesAreFarLessWork) {
  int returns = 0;
  for (double times = 0.5; times < 1.5; times *= 1.03) {
    March m(1.0);
    Contacts contacts;
    contacts.stiffness = 1e-6;
    const SplitDamper damper(0.0);
    m.loads = {&contacts, &damper};
    m.params.max_substeps = 10;
    m.model.stable_step = 0.02 / (times * kCostOfImplicit);
    for (int k = 0; k < 40; ++k) {
      const double work = m.march.memory().implicit_work;
      const solve::TimeMarch::Outcome taken = m.march.step(0.01 * k, m.state);
      if (taken.type == solve::IntegratorType::kImplicit) continue;
      EXPECT_LT(taken.report.substeps, 1.03 * 0.5 * work);
      ++returns;
      break;
    }
  }
  EXPECT_GT(returns, 5);
}

TEST(TimeMarch, AutoLeavesVerletOnlyWhereItIsFarMoreWork) {
  for (const auto& [substeps, type] : {std::pair(150, solve::IntegratorType::kVerlet), {250, solve::IntegratorType::kImplicit}}) {
    March m(1.0);
    const Rubbing rubbing;  // so that slow forces act in every sub-step
    m.loads.push_back(&rubbing);
    m.params.max_substeps = 10;
    m.model.stable_step = 0.02 / (1.8 * substeps);
    solve::TimeMarch::Memory memory = m.march.memory();
    memory.type = solve::IntegratorType::kVerlet;
    memory.implicit_work = 100.0;
    m.march.setMemory(memory);
    EXPECT_EQ(m.march.step(0.0, m.state).type, type) << substeps;
  }
}

TEST(TimeMarch, AutoNeverReturnsToMoreThanAMillionSubsteps) {
  March m(1.0);
  m.model.stable_step = 0.02 / 2e6;
  solve::TimeMarch::Memory memory = m.march.memory();
  memory.implicit_work = 1e9;
  m.march.setMemory(memory);
  EXPECT_EQ(m.march.step(0.0, m.state).type, solve::IntegratorType::kImplicit);
}

// A spring to the origin that Newton's method does not know of.
class UnknownSpring : public Rubbing {
 public:
  void addForces(double, const State& state, Points& forces) const override { forces[0] -= stiffness * state.positions[0]; }
  double potential(double, const State& state) const override { return 0.5 * stiffness * state.positions[0].squaredNorm(); }
  bool isConservative() const override { return true; }
  double stiffness = 0.0;  // N/m
};

TEST(TimeMarch, AutoKeepsToImplicitStepsThroughOneThatTakesFarMoreWork) {
  March m(1.0);
  UnknownSpring spring;
  m.loads.push_back(&spring);
  m.params.max_substeps = 10;
  m.model.stable_step = 0.02 / (4 * kCostOfImplicit);
  findTypes(m, 20);
  const double usual = m.march.memory().implicit_work;
  spring.stiffness = 1e4;
  m.march.loadsChanged();
  const solve::TimeMarch::Outcome costly = m.march.step(0.2, m.state);
  ASSERT_TRUE(costly.ok);
  EXPECT_GT(costly.report.passes, 4.0 * usual);
  spring.stiffness = 0.0;
  m.march.loadsChanged();
  EXPECT_EQ(count(findTypes(m, 20).first, solve::IntegratorType::kImplicit), 20);
}

TEST(TimeMarch, AutoChoosesTheSameFromAMemory) {
  March m(1.0), other(1.0);
  for (March* march : {&m, &other}) {
    march->params.max_substeps = 10;
    march->model.stable_step = 0.02 / (kCostOfImplicit / 4);
  }
  for (const int before : {1, 2, 20}) {
    findTypes(m, before);
    other.state = m.state;
    other.march.setMemory(m.march.memory());
    EXPECT_EQ(findTypes(m, 30), findTypes(other, 30));
    EXPECT_EQ(m.state.positions, other.state.positions);
  }
}

TEST(TimeMarch, UnderAScopeNoForcesAreEvaluatedAnyMoreOnceItIsInterrupted) {
  for (const solve::IntegratorType type : {solve::IntegratorType::kVerlet, solve::IntegratorType::kSymplecticEuler}) {
    SCOPED_TRACE(static_cast<int>(type));
    Interrupter load;
    March m(1.0);
    m.loads = {&load};
    m.params.type = type;
    m.model.change(1e-5);
    load.left = 100;
    const InterruptScope scope(load.interrupt);
    EXPECT_THROW(m.march.step(0.0, m.state), Interrupted);
    EXPECT_EQ(load.left, 0);
  }
}

// A spring to the origin that Newton's method does not know of: it takes very many iterations.
class HiddenSpring : public Interrupter {
 public:
  void addForces(double time, const State& state, Points& forces) const override {
    Interrupter::addForces(time, state, forces);
    forces[0] -= 50.0 * state.positions[0];
  }
  double potential(double, const State& state) const override { return 25.0 * state.positions[0].squaredNorm(); }
};

TEST(TimeMarch, AnInterruptedSolutionEndsBetweenTwoIterationsAndKeepsTheState) {
  for (const solve::IntegratorType type : {solve::IntegratorType::kImplicit, solve::IntegratorType::kStatic}) {
    HiddenSpring load;
    March m(1.0);
    m.loads = {&load};
    m.params.type = type;
    m.params.time_step = 10.0;
    m.params.tolerance = 1e-13;
    m.params.max_iterations = 10000;
    load.left = 1000000;
    const State before = m.state;
    solve::TimeMarch::Outcome outcome = m.march.step(0.0, m.state);
    const int asked = 1000000 - load.left;
    ASSERT_GT(asked, 100);  // the number of force evaluations without an interrupt
    m.march.setInterrupt(&load.interrupt);
    m.march.restart();
    m.state = before;
    load.left = 20;
    outcome = m.march.step(0.0, m.state);
    EXPECT_FALSE(outcome.ok);
    EXPECT_EQ(outcome.failure.kind, solve::StepFailure::Kind::kInterrupted);
    EXPECT_GT(load.left, -10) << static_cast<int>(type);
    EXPECT_EQ(m.state.positions, before.positions);
    EXPECT_EQ(m.state.velocities, before.velocities);
  }
}

TEST(TimeMarch, KnowsTheForcesOfTheStateThatItsStepEndedWithToTheBit) {
  March m(1.0);
  m.held[0] = 0;
  Points known, found;
  for (int k = 0; k < 3; ++k) {
    m.countSubsteps();
    const int evaluations = m.model.evaluations;
    m.march.computeForcesOnAll(0.0, m.state, known);
    EXPECT_EQ(m.model.evaluations, evaluations);
    m.system.computeForcesOnAll(0.0, m.state, found);
    EXPECT_GT(found[0].norm(), 0.0);
    EXPECT_EQ(known, found);
  }
  // For another state the forces are not known.
  m.state.positions[0].x() += 0.5;
  m.march.computeForcesOnAll(0.0, m.state, known);
  m.system.computeForcesOnAll(0.0, m.state, found);
  EXPECT_EQ(known, found);
  // Nor are those that depend on velocities.
  SlowerOscillators viscous({1.0}, 1e-3, 1.0, 0.5);
  const solve::System system(viscous, m.loads, m.held, 0.0);
  solve::TimeMarch march(system, viscous, m.params);
  State state{{Vec3(1.0, 0.0, 0.0)}, {Vec3::Zero()}};
  ASSERT_TRUE(march.step(0.0, state).ok);
  state.velocities[0].x() += 1.0;
  march.computeForcesOnAll(0.0, state, known);
  system.computeForcesOnAll(0.0, state, found);
  EXPECT_EQ(known, found);
}

/// A spring to the origin that breaks when the point is farther from it than 0.3 m.
class Breakable : public Oscillators, public solve::Breaking {
 public:
  Breakable() : Oscillators({100.0}, 1.0) {}
  void addForces(const State& s, Points& forces) const override {
    if (is_whole) Oscillators::addForces(s, forces);
  }
  double elasticEnergy(const State& s) const override { return is_whole ? Oscillators::elasticEnergy(s) : 0.0; }

  bool isAnyStretched(const model::DeformableModel&, const State& s) const override {
    return is_whole && s.positions[0].norm() > 0.3;
  }
  std::optional<double> breakStretched(const State& s) override {
    if (!isAnyStretched(*this, s)) return {};
    const double energy = elasticEnergy(s);
    is_whole = false;
    if (interrupt) *interrupt = true;
    // A step whose energy is not a number is tried again.
    return num_failures-- > 0 ? std::numeric_limits<double>::quiet_NaN() : energy;
  }
  void takeBack() override {
    is_whole = true;
    ++num_taken_back;
  }

  bool is_whole = true;
  int num_failures = 0, num_taken_back = 0;
  std::atomic<bool>* interrupt = nullptr;
};

/// The point flies away from the origin with 5 m/s.
struct BreakableMarch {
  BreakableMarch(double step, solve::IntegratorType type) : system(model, loads, held, 0.0), march(system, model, params) {
    system.setBreaking(&model);
    params.time_step = step;
    params.type = type;
    march.setFineness(static_cast<Index>(std::lround(step / 1e-3)));  // in a sub-step it moves by 5 mm
  }

  Breakable model;
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held{0};
  solve::System system;
  solve::IntegratorParams params;
  solve::TimeMarch march;
  State state{{Vec3::Zero()}, {Vec3(5.0, 0.0, 0.0)}};
};

// It goes on with what speed is left: v^2 = 5^2 - 10^2 0.3^2, after x = 0.5 sin 10 t has come to 0.3.
TEST(TimeMarch, WhatIsStretchedTooFarBreaksWithinTheStep) {
  const double speed = 4.0, at = std::asin(0.6) / 10.0, end = 0.2;
  for (const solve::IntegratorType type :
       {solve::IntegratorType::kVerlet, solve::IntegratorType::kSymplecticEuler, solve::IntegratorType::kImplicit})
    for (const double step : {0.2, 0.1, 0.01}) {
      BreakableMarch m(step, type);
      for (int k = 0; k < std::lround(end / step); ++k) ASSERT_TRUE(m.march.step(k * step, m.state).ok) << step;
      EXPECT_FALSE(m.model.is_whole);
      EXPECT_NEAR(m.state.velocities[0].x(), speed, 0.03 * speed) << step;
      EXPECT_NEAR(m.state.positions[0].x(), 0.3 + speed * (end - at), 0.01) << step;
    }
}

TEST(TimeMarch, WhatBreaksInAStepThatIsTriedAgainIsWholeAgain) {
  for (const solve::IntegratorType type : {solve::IntegratorType::kVerlet, solve::IntegratorType::kImplicit}) {
    BreakableMarch once(0.1, type), again(0.1, type);
    again.model.num_failures = 1;
    ASSERT_TRUE(once.march.step(0.0, once.state).ok);
    const solve::TimeMarch::Outcome taken = again.march.step(0.0, again.state);
    ASSERT_TRUE(taken.ok);
    EXPECT_GT(again.model.num_taken_back, once.model.num_taken_back);
    EXPECT_FALSE(again.model.is_whole);
    EXPECT_NEAR(again.state.positions[0].x(), once.state.positions[0].x(), 0.01);
  }
}

TEST(TimeMarch, WhatBreaksInAStepThatIsInterruptedIsWholeAgain) {
  std::atomic<bool> interrupt(false);
  BreakableMarch m(0.1, solve::IntegratorType::kVerlet);
  m.model.interrupt = &interrupt;
  m.march.setInterrupt(&interrupt);
  EXPECT_FALSE(m.march.step(0.0, m.state).ok);
  EXPECT_TRUE(m.model.is_whole);
  EXPECT_EQ(m.state.positions[0], Vec3::Zero());
}

}  // namespace
}  // namespace deformable_surface::test
