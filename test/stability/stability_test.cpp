// A few cases of every family of the stability suite (docs/stability.md); the benchmark runs all of them.
#include "../support/stability_judge.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using solve::IntegratorType;

constexpr unsigned kSeeds = 12;

class Stability : public ::testing::TestWithParam<std::string> {};

TEST_P(Stability, TheDefaultIntegratorTakesEveryStepSoundly) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const StabilityVerdict verdict = StabilityJudge::judge(StabilityGenerator::make(GetParam(), seed), IntegratorType::kAuto);
    EXPECT_EQ(verdict.kind, StabilityVerdict::kPassed) << "seed " << seed << ": " << verdict.reason;
  }
}

// Explicit Euler fails in most of these. It must never return a broken surface.
TEST_P(Stability, ExplicitEulerAsPublishedIsRefusedBeforeItBlowsUp) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const StabilityCase scene = StabilityGenerator::make(GetParam(), seed);
    const StabilityVerdict verdict = StabilityJudge::judge(scene, IntegratorType::kExplicitEuler);
    EXPECT_NE(verdict.kind, StabilityVerdict::kFailed) << "seed " << seed << ": " << verdict.reason;
  }
}

INSTANTIATE_TEST_SUITE_P(Families, Stability, ::testing::ValuesIn(stabilityFamilies()),
                         [](const ::testing::TestParamInfo<std::string>& info) { return info.param; });

}  // namespace
}  // namespace deformable_surface::test
