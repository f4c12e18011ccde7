// Elastic solids that flow, as scenes: the permanent deformation, the energy account, and snapshots.
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "support/figures.h"

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

void run(Simulation& s, int steps) {
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
  }
}

double findTip(Simulation& s) { return findLargestMotion(s, Vec3(0.399, -1.0, -1.0), Vec3(1.0, 1.0, 1.0)); }

// The bar of the scene, with fewer points. The ball presses its end down by 0.12 m.
SceneParams makeBar(double yield) {
  SceneParams scene = loadScene("solid_plastic");
  scene.cloud.points = 500;
  scene.elastic_solid.plasticity.yield_stress = yield;
  return scene;
}

TEST(SolidPlasticity, KeepsABarBentBeyondItsYieldAndLetsItGoBackBelow) {
  double left[2], most[2];
  for (const double yield : {2e4, 1e6}) {
    Simulation s = makeSimulation(makeBar(yield));
    run(s, 50);
    most[yield > 1e5] = findTip(s);
    run(s, 150);
    left[yield > 1e5] = findTip(s);
  }
  EXPECT_GT(left[0], 0.3 * most[0]);
  EXPECT_LT(left[0], most[0]);
  EXPECT_LT(left[1], 1e-3 * most[1]);
}

// Undamped, with gravity that sets in at once: the missing energy is that of the flow.
TEST(SolidPlasticity, KeepsTheAccountOfTheEnergy) {
  SceneParams scene = makeBar(4e3);
  scene.tools.clear();
  scene.material.damping = 0.0;
  scene.gravity = Vec3(0.0, 0.0, -9.81);
  Simulation s = makeSimulation(scene);
  const double before = s.statistics().potential_energy;
  double largest = 0.0;
  for (int k = 0; k < 60; ++k) {
    run(s, 1);
    const simulation::Statistics now = s.statistics();
    largest = std::max(largest, now.kinetic_energy);
    EXPECT_NEAR(now.kinetic_energy + now.elastic_energy + now.potential_energy + s.state().dissipated, before,
                0.02 * largest + 1e-9);
  }
  EXPECT_GT(s.state().dissipated, 0.1 * largest);
}

TEST(SolidPlasticity, IsHeldByASnapshotAndByAFork) {
  Simulation s = makeSimulation(makeBar(2e4));
  run(s, 40);
  const simulation::Snapshot snapshot = s.snapshot();
  Simulation fork = s.fork();
  run(s, 20);
  const std::uint64_t hash = s.stateHash();
  run(fork, 20);
  EXPECT_EQ(fork.stateHash(), hash);
  s.restore(snapshot);
  run(s, 20);
  EXPECT_EQ(s.stateHash(), hash);
  // A reset removes the plastic strain.
  Simulation fresh = makeSimulation(makeBar(2e4));
  run(fresh, 60);
  s.reset();
  run(s, 60);
  EXPECT_EQ(s.stateHash(), fresh.stateHash());
}

TEST(SolidPlasticity, IsTakenFromAStateThatIsGiven) {
  Simulation s = makeSimulation(makeBar(2e4)), other = makeSimulation(makeBar(2e4));
  run(s, 60);
  const model::State bent = s.state();
  const double energy = s.statistics().elastic_energy;
  ASSERT_GT(bent.dissipated, 0.0);
  other.setState(bent);
  EXPECT_EQ(other.state().dissipated, bent.dissipated);
  EXPECT_EQ(other.state().plastic, bent.plastic);
  EXPECT_NEAR(other.statistics().elastic_energy, energy, 1e-12 * energy);
  // What is left empty stays.
  model::State places = bent;
  places.plastic.clear();
  other.setState(places);
  EXPECT_EQ(other.state().plastic, bent.plastic);

  const std::uint64_t before = other.stateHash();
  places.plastic.assign(3, Mat3::Identity());
  EXPECT_THROW(other.setState(places), InputError);
  model::State inside_out = bent;
  inside_out.plastic[1] *= -1.0;
  EXPECT_THROW(other.setState(inside_out), InputError);
  inside_out.plastic[1].setConstant(std::nan(""));
  EXPECT_THROW(other.setState(inside_out), InputError);
  EXPECT_EQ(other.stateHash(), before);
}

TEST(SolidPlasticity, GivesTheSameBitsForEveryNumberOfThreads) {
  std::uint64_t hash = 0;
  for (const Index threads : {1, 3}) {
    SceneParams scene = makeBar(2e4);
    setNumThreads(threads);
    Simulation s = makeSimulation(scene);
    run(s, 40);
    if (threads == 1) hash = s.stateHash();
    EXPECT_EQ(s.stateHash(), hash);
    EXPECT_GT(s.state().dissipated, 0.0);
  }
  setNumThreads(0);
}

}  // namespace
}  // namespace deformable_surface::test
