// Frequencies of membranes under tension and of a cantilever.
#include "series.h"

namespace deformable_surface::physics {
namespace {

TEST(HangingStripThatSwings, HasTheFrequencyOfTheBesselRoot) {
  const Problem problem = findProblem(listVibrations(), "hanging strip, frequency");
  for (const Variant& variant : problem.variants)
    if (isTriangles(variant)) {
      EXPECT_LT(ask(problem, variant, 1)[0].error, 0.01) << describe(problem, variant);
    }
}

TEST(StretchedSquare, HasTheFrequencyOfItsTension) {
  const Problem problem = findProblem(listVibrations(), "stretched square, frequency");
  for (const Variant& variant : problem.variants) {
    const std::vector<Answer> answers = ask(problem, variant, 2);
    // Sixteen points along the side. On jittered points springs are soft, and so is the tension.
    EXPECT_LT(answers[1].error, isTriangles(variant) ? 0.005 : 0.05) << describe(problem, variant);
    if (isTriangles(variant)) {
      EXPECT_GT(fitOrder(answers).value, 1.5) << describe(problem, variant);
    }
  }
}

}  // namespace
}  // namespace deformable_surface::physics
