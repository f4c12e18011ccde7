// A shell of double curvature under point loads.
#include "series.h"

namespace deformable_surface::physics {
namespace {

// Pressed in by a fifth and by six tenths of its radius. Finer points and the full load are part of the benchmark.
TEST(Hemisphere, FollowsThePublishedTableBetterOnMorePoints) {
  const Problem tenth = findProblem(listShells(), "hemisphere, tenth of the load");
  for (const Variant& variant : tenth.variants) {
    const std::vector<Answer> answers = ask(tenth, variant, 2);
    EXPECT_LT(answers[1].error, 0.04) << describe(tenth, variant);
    EXPECT_LT(answers[1].error, 0.75 * answers[0].error) << describe(tenth, variant);
  }
  const Problem half = findProblem(listShells(), "hemisphere, half of the load");
  for (const Variant& variant : half.variants) EXPECT_LT(ask(half, variant, 1)[0].error, 0.08) << describe(half, variant);
}

}  // namespace
}  // namespace deformable_surface::physics
