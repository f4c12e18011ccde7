// Runs in which a surface touches itself can be continued and copied, and do not depend on the number of threads.
#include "../../src/simulation/self_contact_load.h"
#include "self_contact_runs.h"

namespace deformable_surface::test {
namespace {

using simulation::Simulation;

TEST(SelfContactCopies, ARunFromASnapshotAndAForkAreTheSame) {
  ContactScene scene = makeScene("fold", 1, 1.0);
  scene.params.contact.friction = 0.3;
  Simulation s(scene.params, scene.cloud);
  run(s, 150);
  ASSERT_GT(s.statistics().self_contacts, 0u);
  const simulation::Snapshot snapshot = s.snapshot();
  Simulation fork = s.fork();
  run(s, 30);
  run(fork, 30);
  EXPECT_EQ(s.stateHash(), fork.stateHash());
  const std::uint64_t hash = s.stateHash();
  s.restore(snapshot);
  run(s, 30);
  EXPECT_EQ(s.stateHash(), hash);
}

// Also before anything touches, where a proof that nothing does serves several steps.
TEST(SelfContactCopies, AnotherSimulationContinuesASnapshot) {
  ContactScene scene = makeScene("drop", 4, 1.0);
  Simulation whole(scene.params, scene.cloud);
  std::vector<simulation::Snapshot> snapshots;
  Index touched = 0;
  for (int step = 0; step < 90; ++step) {
    if (step % 15 == 4) snapshots.push_back(whole.snapshot());
    run(whole, 1);
    touched += static_cast<Index>(whole.statistics().self_contacts);
  }
  EXPECT_GT(touched, 0);
  for (std::size_t k = 0; k < snapshots.size(); ++k) {
    Simulation rest(scene.params, scene.cloud);
    run(rest, 3);
    rest.restore(snapshots[k]);
    run(rest, 86 - 15 * static_cast<int>(k));
    EXPECT_EQ(rest.stateHash(), whole.stateHash()) << k;
  }
  whole.reset();
  run(whole, 90);
  Simulation again(scene.params, scene.cloud);
  run(again, 90);
  EXPECT_EQ(whole.stateHash(), again.stateHash());
}

// A closed surface by default: what the last quick look saw belongs to the state.
TEST(SelfContactCopies, AClosedSurfaceContinuesWithTheSameBits) {
  simulation::SceneParams p;
  p.material.young_modulus = 2e4;
  p.material.damping = 3.0;
  p.integrator.time_step = 0.005;
  p.accuracy.estimate = false;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(1.0, 1.0, -0.12);
  p.pins = {pin};
  const cloud::PointCloud ball = asCloud(makeSphere(400, 0.16).points);
  std::vector<std::uint64_t> hashes;
  for (const Index threads : {1, 2, 3}) {
    p.threads = threads;
    Simulation s(p, ball);
    std::vector<simulation::Snapshot> snapshots;
    Index touched = 0;
    for (int k = 0; k < 60; ++k) {
      if (k % 7 == 3) snapshots.push_back(s.snapshot());
      run(s, 1);
      if (threads == 2) touched += static_cast<Index>(s.statistics().self_contacts);
    }
    hashes.push_back(s.stateHash());
    if (threads != 2) continue;
    EXPECT_GT(touched, 0);
    for (std::size_t k = 0; k < snapshots.size(); ++k) {
      Simulation other(p, ball);
      run(other, 2);
      other.restore(snapshots[k]);
      Simulation fork = other.fork();
      run(other, 57 - 7 * static_cast<int>(k));
      run(fork, 57 - 7 * static_cast<int>(k));
      EXPECT_EQ(other.stateHash(), hashes[1]) << k;
      EXPECT_EQ(fork.stateHash(), hashes[1]) << k;
    }
    s.reset();
    run(s, 60);
    EXPECT_EQ(s.stateHash(), hashes[1]);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(SelfContactCopies, ResultsDoNotDependOnTheNumberOfThreads) {
  ContactScene scene = makeScene("drop", 4, 0.6);
  std::uint64_t hash = 0;
  for (const Index threads : {1, 2, 3}) {
    scene.params.threads = threads;
    Simulation s(scene.params, scene.cloud);
    run(s, 80);
    if (threads == 1) hash = s.stateHash();
    EXPECT_EQ(s.stateHash(), hash) << threads;
  }
}

}  // namespace
}  // namespace deformable_surface::test
