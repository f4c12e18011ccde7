// Runs that must go on bit for bit.
#pragma once

#include "clouds.h"
#include "deformable_surface/simulation/simulation.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {

/// After some steps, twenty more give the same hash in the run itself, in a fork, after a snapshot is restored, and in a second
/// run from the beginning.
inline void expectToGoOnBitForBit(const simulation::SceneParams& params, const cloud::PointCloud& cloud, int steps) {
  simulation::Simulation s(params, cloud);
  run(s, steps);
  const simulation::Snapshot kept = s.snapshot();
  simulation::Simulation fork = s.fork();
  run(s, 20);
  run(fork, 20);
  EXPECT_EQ(fork.stateHash(), s.stateHash());
  const auto hash = s.stateHash();
  s.restore(kept);
  run(s, 20);
  EXPECT_EQ(s.stateHash(), hash);
  simulation::Simulation again(params, cloud);
  run(again, steps + 20);
  EXPECT_EQ(again.stateHash(), hash);
}

}  // namespace deformable_surface::test
