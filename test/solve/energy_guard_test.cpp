// Blow-ups are distinguished from the normal behaviour of the methods: oscillation of the energy, first steps, drift, commands.
#include "deformable_surface/solve/energy_guard.h"
#include "oscillators.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace deformable_surface::test {
namespace {

using solve::EnergyGuard;
using solve::IntegratorType;

const std::vector<char> kFree(1, 0);
const std::vector<const solve::ExternalLoad*> kNoLoads;

// Steps of w h from rest, one metre away. Returns the number of steps that the guard accepts.
int countAccepted(IntegratorType type, double w_times_step, int steps, const EnergyGuard::Allowance& allowance) {
  const Oscillators model({1.0}, 1.0);
  const solve::System system(model, kNoLoads, kFree, 0.0);
  const auto integrator = solve::makeIntegrator(type, {});
  EnergyGuard guard;
  State state{{Vec3(1.0, 0.0, 0.0)}, {Vec3::Zero()}};
  for (int k = 0; k < steps; ++k) {
    guard.beginStep(system, 0.0, state);
    // A stable step so long that the integrator needs one sub-step.
    integrator->advance(system, 0.0, w_times_step, 100.0, state);
    if (!guard.accepts(system, 0.0, state, w_times_step, 0.0, allowance)) return k;
    guard.commit();
  }
  return steps;
}

TEST(EnergyGuard, TheOscillationOfVerletsEnergyAtHalfTheStableStepIsNoBlowUp) {
  for (double w_times_step : {0.1, 0.5, 1.0})
    EXPECT_EQ(countAccepted(IntegratorType::kVerlet, w_times_step, 10000, EnergyGuard::kSymplectic), 10000);
}

TEST(EnergyGuard, AVerletThatIsUnstableIsCaughtWithinAFewSteps) {
  for (double w_times_step : {2.01, 2.1, 4.0, 100.0})
    EXPECT_LT(countAccepted(IntegratorType::kVerlet, w_times_step, 1000, EnergyGuard::kSymplectic), 5);
}

TEST(EnergyGuard, ExplicitEulerMayDriftButNotBlowUp) {
  // The energy grows by (w h)^2 in every step.
  EXPECT_EQ(countAccepted(IntegratorType::kExplicitEuler, 0.02, 1000, EnergyGuard::kPublished), 1000);
  EXPECT_LT(countAccepted(IntegratorType::kExplicitEuler, 0.3, 10000, EnergyGuard::kPublished), 20);
}

TEST(EnergyGuard, AMethodThatOnlyDescendsMayNotSwing) {
  const auto count = [](const EnergyGuard::Allowance& allowance) {
    return countAccepted(IntegratorType::kVerlet, 1.0, 100, allowance);
  };
  EXPECT_EQ(count(EnergyGuard::kSymplectic), 100);
  EXPECT_LT(count(EnergyGuard::kDescending), 10);
}

TEST(EnergyGuard, EveryMethodMayFall) {
  const Oscillators model({0.0}, 2.0);
  const ConstantField gravity(model.masses(), Vec3(0.0, 0.0, -9.81));
  const std::vector<const solve::ExternalLoad*> loads{&gravity};
  const solve::System system(model, loads, kFree, 0.0);
  for (IntegratorType type :
       {IntegratorType::kExplicitEuler, IntegratorType::kSymplecticEuler, IntegratorType::kVerlet, IntegratorType::kImplicit}) {
    const auto integrator = solve::makeIntegrator(type, {});
    EnergyGuard guard;
    State state{{Vec3::Zero()}, {Vec3::Zero()}};
    for (int k = 0; k < 200; ++k) {
      guard.beginStep(system, 0.0, state);
      integrator->advance(system, 0.0, 0.01, 1.0, state);
      const bool accepted = guard.accepts(system, 0.0, state, 0.01, 0.0, EnergyGuard::kSymplectic);
      ASSERT_TRUE(accepted) << static_cast<int>(type) << " step " << k;
      guard.commit();
    }
  }
}

TEST(EnergyGuard, WhatACommandOrALoadPutsInIsNoGain) {
  const Oscillators model({1.0}, 1.0);
  const solve::System system(model, kNoLoads, kFree, 0.0);
  EnergyGuard guard;
  State state{{Vec3(1.0, 0.0, 0.0)}, {Vec3::Zero()}};
  guard.beginStep(system, 0.0, state);
  ASSERT_TRUE(guard.accepts(system, 0.0, state, 0.01, 0.0, EnergyGuard::kSymplectic));
  guard.commit();
  // An impulse between two steps: the next step begins with more energy.
  state.velocities[0].x() = 100.0;
  guard.beginStep(system, 0.0, state);
  EXPECT_TRUE(guard.accepts(system, 0.0, state, 0.01, 0.0, EnergyGuard::kSymplectic));
  guard.commit();
  // The same within a step is a gain, unless a load reports the work.
  guard.beginStep(system, 0.0, state);
  state.velocities[0].x() = 200.0;
  EXPECT_FALSE(guard.accepts(system, 0.0, state, 0.01, 0.0, EnergyGuard::kSymplectic));
  EXPECT_TRUE(guard.accepts(system, 0.0, state, 0.01, 15000.0, EnergyGuard::kSymplectic));
  // Values that are not finite are never sound.
  state.velocities[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(guard.accepts(system, 0.0, state, 0.01, std::numeric_limits<double>::infinity(), EnergyGuard::kSymplectic));
}

}  // namespace
}  // namespace deformable_surface::test
