// Inside one body the region around a poke is awake and the rest sleeps.
#include "deformable_surface/io/shapes.h"
#include "sleeping.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using simulation::Sleep;

constexpr double kTolerance = kSleepTolerance;

// A slab of jelly that sticks to a table, poked near a corner from the sixth step on.
SceneParams pokedSlab() {
  SceneParams p;
  p.model = "elastic_solid";
  p.cloud.shape = simulation::CloudParams::Shape::kBar;
  p.cloud.points = 2700;
  p.cloud.size = Vec2(0.6, 0.6);
  p.cloud.height = 0.06;
  p.cloud.jitter = 0.2;
  p.gravity.setZero();
  p.material.young_modulus = 5e3;
  p.material.poisson_ratio = 0.3;
  p.material.damping = 20.0;
  simulation::PinParams table;
  table.region.min = Vec3(-1.0, -1.0, -1.0);
  table.region.max = Vec3(1.0, 1.0, -0.03 + 1e-6);
  p.pins.push_back(table);
  p.integrator.time_step = 2e-3;
  p.sleep.quiet_time = 0.05;
  p.sleep.tolerance = kTolerance;
  p.accuracy.estimate = false;
  p.forces.push_back({"poke", Vec3(0.5, 0.1, 0.03), Vec3(0.2, 0.0, -0.5), 0.05, 0.01, 0.03});
  return p;
}

TEST(SleepingSolids, APokeMovesWhatItMovesAndTheRestSleepsWhereItIs) {
  SceneParams p = pokedSlab();
  const cloud::PointCloud slab = io::makeShape(p.cloud);
  Simulation s(p, slab);
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, slab);
  run(s, 5);
  run(never, 5);
  EXPECT_EQ(s.statistics().awake, 0u);
  std::uint32_t least = static_cast<std::uint32_t>(slab.positions.size());
  double moved = 0.0;
  for (int k = 0; k < 40; ++k) {
    run(s, 1);
    run(never, 1);
    ASSERT_GT(s.statistics().awake, 0u) << k;
    least = std::min(least, s.statistics().awake);
    for (Index i = 0; i < s.state().size(); ++i)
      if (!s.isAwake(i)) {
        ASSERT_TRUE(s.state().velocities[i].isZero(0.0));
        ASSERT_LT((s.state().positions[i] - s.input().positions[i]).norm(), kTolerance);
      }
    moved = std::max(moved, largestDistance(never.state().positions, never.input().positions));
    EXPECT_LT(largestDistance(s.state().positions, never.state().positions), kTolerance) << k;
  }
  EXPECT_LT(least, 0.2 * s.state().size());
  EXPECT_GT(moved, 100.0 * kTolerance);
}

TEST(SleepingSolids, AnImplicitStepOfAPartIsThatOfTheWhole) {
  SceneParams p = pokedSlab();
  p.integrator.type = solve::IntegratorType::kImplicit;
  p.integrator.tolerance = 1e-10;
  p.material.damping = 200.0;
  const cloud::PointCloud slab = io::makeShape(p.cloud);
  Simulation s(p, slab);
  p.sleep.mode = Sleep::kNever;
  Simulation never(p, slab);
  bool was_part = false;
  for (int k = 0; k < 8; ++k) {
    run(s, 1);
    run(never, 1);
    was_part = was_part || isPartlyAwake(s);
    EXPECT_LT(largestDistance(s.state().positions, never.state().positions), kTolerance) << k;
  }
  EXPECT_TRUE(was_part);
}

TEST(SleepingSolids, APartIsBitIdenticalForOneTwoAndThreeThreadsAndThroughSnapshots) {
  expectSameBitsInParts(pokedSlab(), io::makeShape(pokedSlab().cloud), 7, 4);
}

}  // namespace
}  // namespace deformable_surface::test
