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
