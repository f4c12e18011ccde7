// The same input gives the same bits: twice, with any number of threads, through a reset.
#include "../simulation/clouds.h"
#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <cstring>

namespace deformable_surface::test {
namespace {

struct Result {
  std::uint64_t hash;
  std::vector<std::uint64_t> surface;

  bool operator==(const Result& other) const { return hash == other.hash && surface == other.surface; }
};

// Large enough that every parallel loop has several blocks.
Result simulate(int threads, solve::IntegratorType type) {
  setNumThreads(threads);
  simulation::SceneParams p = hangingSheet();
  p.integrator.type = type;
  p.material.spring_damping = 1e-4;
  p.pressure = 0.1;
  p.viscous_drag = 0.1;
  const bool is_explicit = type == solve::IntegratorType::kVerlet;
  p.simplification.target_points = is_explicit ? 3000 : 300;
  simulation::Simulation s(p, sheetCloud(is_explicit ? 90 : 60));
  run(s, is_explicit ? 5 : 3);
  Result result{s.stateHash(), {}};
  for (const Vec3& x : s.surface(true).positions)
    for (int c = 0; c < 3; ++c) {
      std::uint64_t bits;
      std::memcpy(&bits, &x[c], sizeof bits);
      result.surface.push_back(bits);
    }
  setNumThreads(0);
  return result;
}

TEST(Determinism, ExplicitRunsAreBitIdenticalForOneTwoAndThreeThreads) {
  const Result one = simulate(1, solve::IntegratorType::kVerlet);
  EXPECT_TRUE(one == simulate(1, solve::IntegratorType::kVerlet));
  EXPECT_TRUE(one == simulate(2, solve::IntegratorType::kVerlet));
  EXPECT_TRUE(one == simulate(3, solve::IntegratorType::kVerlet));
}

TEST(Determinism, ImplicitRunsAreBitIdenticalForOneTwoAndThreeThreads) {
  const Result one = simulate(1, solve::IntegratorType::kImplicit);
  EXPECT_TRUE(one == simulate(2, solve::IntegratorType::kImplicit));
  EXPECT_TRUE(one == simulate(3, solve::IntegratorType::kImplicit));
}

}  // namespace
}  // namespace deformable_surface::test
