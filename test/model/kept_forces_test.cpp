// Forces of kept bonds: gradients, rest, momenta, and the number of threads.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/solve/integrator.h"
#include "kept_patches.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

TEST(KeptForces, ForcesAndTorquesAreMinusTheGradientAndKeepMomenta) {
  for (const double bend : {0.0, 2.0}) {
    State s = shaken(unevenPatch(bend), 0.15);
    const OrientedParticles particles = makeKept(unevenPatch(bend));
    for (Index i = 0; i < s.size(); i += 3) s.traits[i].temperature = 300.0;
    s.traits[8].is_smooth = false;
    s.positions[40] = s.positions[1] + Vec3(0.1, 0.2, 0.6) * kSpacing;  // without a bond, near
    Points forces, torques;
    evaluate(particles, s, forces, torques);
    const double h = 1e-4, force_scale = largest(forces), torque_scale = largest(torques);
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (Index i = 0; i < s.size(); ++i) {
      sum += forces[i];
      moment += torques[i] + s.positions[i].cross(forces[i]);
      for (int axis = 0; axis < 6; ++axis) {
        const auto energyAt = [&](double amount) {
          State moved = s;
          if (axis < 3)
            moved.positions[i] += amount * kSpacing * Vec3::Unit(axis);
          else
            moved.orientations[i] = turnBy(amount * Vec3::Unit(axis - 3), moved.orientations[i]);
          return particles.elasticEnergy(moved);
        };
        const double slope = (8.0 * (energyAt(h) - energyAt(-h)) - (energyAt(2 * h) - energyAt(-2 * h))) / (12.0 * h);
        if (axis < 3)
          EXPECT_NEAR(forces[i][axis], -slope / kSpacing, 1e-7 * force_scale) << i << " " << axis;
        else
          EXPECT_NEAR(torques[i][axis - 3], -slope, 1e-6 * torque_scale) << i << " " << axis;
      }
    }
    EXPECT_LT(sum.norm(), 1e-12 * force_scale);
    EXPECT_LT(moment.norm(), 1e-12 * force_scale);
  }
}

TEST(KeptForces, ACurvedShapeIsAtRestWhereverItIsMoved) {
  const State rest = unevenPatch(2.0);
  const OrientedParticles particles = makeKept(rest);
  State s = rest;
  const Quaternion turn(Eigen::AngleAxisd(1.1, Vec3(1.0, 2.0, -0.5).normalized()));
  for (Index i = 0; i < s.size(); ++i) {
    s.positions[i] = turn * rest.positions[i] + Vec3(3.0, -1.0, 2.0);
    s.orientations[i] = turn * rest.orientations[i];
  }
  Points forces, torques;
  evaluate(particles, s, forces, torques);
  EXPECT_LT(largest(forces), 1e-10 * thinSheet().young_modulus * thinSheet().thickness * kSpacing);
}

TEST(KeptForces, WithoutDampingEnergyAndMomentaStay) {
  State s = unevenPatch(2.0);
  OrientedParticles particles = makeKept(s);
  const double most = 0.02 / particles.findStableStep(s);
  std::mt19937 generator(5);
  for (Index i = 0; i < s.size(); i += 2) {
    s.velocities[i] = most * kSpacing * randomVector(generator);
    s.velocities[i + 1] = -s.velocities[i];
  }
  const auto measureAngularMomentum = [&] {
    Vec3 sum = Vec3::Zero();
    for (Index i = 0; i < s.size(); ++i)
      sum += particles.masses()[i] * s.positions[i].cross(s.velocities[i]) + particles.inertias()[i] * s.spins[i];
    return sum;
  };
  const Vec3 turning = measureAngularMomentum();
  const std::vector<const solve::ExternalLoad*> no_loads;
  const std::vector<char> held(s.positions.size(), 0);
  const solve::System system(particles, no_loads, held, 0.0);
  const double step = 0.5 * particles.findStableStep(s), first = system.kineticEnergy(s);
  const auto verlet = solve::makeIntegrator(solve::IntegratorType::kVerlet, {}, true);
  double lowest = first, highest = first;
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(verlet->advance(system, 0.0, 20.0 * step, step, s).finite);
    const double now = particles.elasticEnergy(s) + system.kineticEnergy(s);
    lowest = std::min(lowest, now);
    highest = std::max(highest, now);
  }
  EXPECT_LT(highest - lowest, 0.02 * first);
  Vec3 momentum = Vec3::Zero();
  for (Index i = 0; i < s.size(); ++i) momentum += particles.masses()[i] * s.velocities[i];
  EXPECT_LT(momentum.norm(), 1e-10 * particles.masses()[0] * most * kSpacing);
  EXPECT_GT(turning.norm(), 0.0);
  EXPECT_LT((measureAngularMomentum() - turning).norm(), 1e-9 * turning.norm());
}

TEST(KeptForces, TheBitsDoNotDependOnThreads) {
  constexpr Index kRows = 40, kColumns = 50;  // several blocks
  const State rest = hexagonalPatch(kRows, kColumns);
  std::vector<WeightedTriangle> triangles;
  for (Index i = 0; i + 1 < kRows; ++i)
    for (Index j = 0; j + 1 < kColumns; ++j) {
      const Index a = kColumns * i + j;
      triangles.push_back({{a, a + 1, a + kColumns + i % 2}, 1.0});
    }
  OrientedParticlesParams p;
  p.bonds = model::ParticleBonds::kKept;
  OrientedParticles particles = makeModel(rest.size(), p, thinSheet());
  particles.keepBonds(rest, triangles, std::vector<double>(rest.size(), kSpacing * kSpacing));
  const State s = shaken(rest, 0.3);
  Points first_forces, first_torques;
  double first_energy = 0.0, first_step = 0.0;
  for (const int threads : {1, 2, 3}) {
    setNumThreads(threads);
    Points forces, torques;
    evaluate(particles, s, forces, torques);
    const double energy = particles.elasticEnergy(s), step = particles.findStableStep(s);
    if (threads == 1) {
      first_forces = forces;
      first_torques = torques;
      first_energy = energy;
      first_step = step;
    }
    EXPECT_EQ(forces, first_forces);
    EXPECT_EQ(torques, first_torques);
    EXPECT_EQ(energy, first_energy);
    EXPECT_EQ(step, first_step);
  }
  setNumThreads(0);
}

}  // namespace
}  // namespace deformable_surface::test
