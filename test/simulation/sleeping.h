// Helpers for the tests of surfaces that sleep in parts.
#pragma once

#include "clouds.h"
#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace deformable_surface::test {

constexpr double kSleepTolerance = 1e-6;  // m

inline double largestDistance(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

inline bool isPartlyAwake(const simulation::Simulation& s) {
  const std::uint32_t awake = s.statistics().awake;
  return awake > 0 && awake < 0.7 * s.state().size();
}

/// A surface that is partly awake after some steps continues with the same bits for one, two and three threads, with and without
/// reads of the statistics, and from a snapshot, in the same simulation and in another.
inline void expectSameBitsInParts(const simulation::SceneParams& params, const cloud::PointCloud& cloud, int before, int after) {
  std::vector<std::uint64_t> first;
  for (int threads : {1, 2, 3}) {
    setNumThreads(threads);
    simulation::Simulation s(params, cloud);
    run(s, before);
    EXPECT_TRUE(isPartlyAwake(s));
    const simulation::Snapshot snapshot = s.snapshot();
    std::vector<std::uint64_t> hashes;
    for (int k = 0; k < after; ++k) {
      run(s, 1);
      if (threads == 2) s.statistics();
      hashes.push_back(s.stateHash());
    }
    EXPECT_TRUE(isPartlyAwake(s));
    if (first.empty()) first = hashes;
    EXPECT_EQ(hashes, first) << threads << " threads";
    simulation::Simulation other(params, cloud);
    for (simulation::Simulation* restored : {&s, &other}) {
      restored->restore(snapshot);
      for (int k = 0; k < after; ++k) {
        run(*restored, 1);
        EXPECT_EQ(restored->stateHash(), first[k]) << k;
      }
    }
  }
  setNumThreads(0);
}

}  // namespace deformable_surface::test
