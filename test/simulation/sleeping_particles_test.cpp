// Inside one surface of oriented particles the region around a poke is awake and the rest is not.
#include "sleeping.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using simulation::Sleep;

constexpr double kTolerance = kSleepTolerance;

// A hexagonal sheet of particles at rest, poked near a corner from the sixth step on.
SceneParams pokedSheet(model::ParticleBonds bonds = model::ParticleBonds::kFree) {
  SceneParams p;
  p.oriented_particles.bonds = bonds;
  p.model = "oriented_particles";
  p.gravity.setZero();
  p.material.young_modulus = 500.0;
  p.material.thickness = 1e-3;
  p.material.damping = 20.0;
  p.material.bending_rigidity = 1e-4;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.integrator.time_step = 2e-3;
  p.sleep.quiet_time = 0.05;
  p.sleep.tolerance = kTolerance;
  p.forces.push_back({"poke", Vec3(0.85, 0.35, 0.0), Vec3(0.01, 0.0, 0.05), 0.04, 0.01, 0.03});
  return p;
}

cloud::PointCloud hexagons() {
  Points points;
  constexpr double kSpacing = 0.025;
  for (int j = 0; j < 46; ++j)
    for (int i = 0; i < 40; ++i) points.emplace_back((i + 0.5 * (j % 2)) * kSpacing, (j - 23) * kSpacing * std::sqrt(0.75), 0.0);
  return asCloud(points);
}

TEST(SleepingParticles, APokeMovesWhatItMovesAndTheRestSleepsWhereItIs) {
  for (const model::ParticleBonds bonds : {model::ParticleBonds::kFree, model::ParticleBonds::kKept}) {
    SceneParams p = pokedSheet(bonds);
    Simulation s(p, hexagons());
    p.sleep.mode = Sleep::kNever;
    Simulation never(p, hexagons());
    run(s, 5);
    run(never, 5);
    EXPECT_EQ(s.statistics().awake, 0u);
    std::uint32_t least = static_cast<std::uint32_t>(s.state().size());
    double moved = 0.0;
    for (int k = 0; k < 30; ++k) {
      run(s, 1);
      run(never, 1);
      ASSERT_TRUE(isPartlyAwake(s)) << k;
      least = std::min(least, s.statistics().awake);
      for (Index i = 0; i < s.state().size(); ++i)
        if (!s.isAwake(i)) {
          ASSERT_TRUE(s.state().velocities[i].isZero(0.0));
          ASSERT_TRUE(s.state().spins[i].isZero(0.0));
        }
      moved = std::max(moved, largestDistance(never.state().positions, never.input().positions));
      EXPECT_LT(largestDistance(s.state().positions, never.state().positions), kTolerance) << k;
    }
    EXPECT_LT(least, 0.2 * s.state().size());
    EXPECT_GT(moved, 1000.0 * kTolerance);
  }
}

TEST(SleepingParticles, APartIsBitIdenticalForOneTwoAndThreeThreadsAndThroughSnapshots) {
  for (const model::ParticleBonds bonds : {model::ParticleBonds::kFree, model::ParticleBonds::kKept})
    expectSameBitsInParts(pokedSheet(bonds), hexagons(), 12, 30);
}

// A flake is pressed onto a sleeping sheet. When the sheet fell asleep, the flake was far beyond its reach.
TEST(SleepingParticles, WhatComesNearFromAfarIsFelt) {
  SceneParams p = pokedSheet();
  cloud::PointCloud sheet = hexagons();
  const Index n = static_cast<Index>(sheet.positions.size());
  const Vec3 middle(0.3, 0.0, 0.075);
  for (int i = 0; i < 7; ++i) {
    const double angle = i * 3.14159265358979 / 3.0, radius = i < 6 ? 0.025 : 0.0;
    sheet.positions.push_back(middle + radius * Vec3(std::cos(angle), std::sin(angle), 0.0));
  }
  sheet = asCloud(sheet.positions);
  p.forces = {{"press", middle, Vec3(0.0, 0.0, -0.02), 0.04, 0.01, 1e300}};
  Simulation s(p, sheet);
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, sheet);
  run(s, 8);
  run(never, 8);
  ASSERT_GT(s.statistics().awake, 0u);
  ASSERT_LT(s.statistics().awake, 0.2 * n);  // the flake, and what shares tiles and elements with it
  double pressed = 0.0;
  for (int k = 0; k < 150; ++k) {
    run(s, 1);
    run(never, 1);
    for (Index i = 0; i < n; ++i) pressed = std::max(pressed, -never.state().positions[i].z());
    ASSERT_TRUE(isPartlyAwake(s)) << k;
    ASSERT_LT(largestDistance(s.state().positions, never.state().positions), kTolerance) << k;
  }
  EXPECT_GT(pressed, 0.005);
}

// Adding and removing particles leaves one tile, and so does restoring such a state. A reset restores the tiles.
TEST(SleepingParticles, ASurfaceWhoseParticlesChangeInNumberSleepsAsAWhole) {
  Simulation s(pokedSheet(), hexagons());
  s.editParticles({simulation::ParticleAction::kDelete, {0}});
  run(s, 8);
  EXPECT_FALSE(isPartlyAwake(s));
  const simulation::Snapshot snapshot = s.snapshot();
  run(s, 20);
  const std::uint64_t hash = s.stateHash();
  Simulation other(pokedSheet(), hexagons());
  run(other, 8);
  EXPECT_TRUE(isPartlyAwake(other));
  other.restore(snapshot);
  run(other, 20);
  EXPECT_EQ(other.stateHash(), hash);
  other.reset();
  run(other, 8);
  EXPECT_TRUE(isPartlyAwake(other));
}

}  // namespace
}  // namespace deformable_surface::test
