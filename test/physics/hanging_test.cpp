// Sheets that stretch under their own weight.
#include "series.h"

namespace deformable_surface::physics {
namespace {

TEST(HangingStrip, StretchesAsStated) {
  const Problem problem = findProblem(listHanging(), "hanging strip");
  for (const Variant& variant : problem.variants) {
    const Answer a = ask(problem, variant, 1, 1)[0];
    // Triangles represent a linear strain exactly. The remaining error is the weight at the end, which lies between the points of
    // a scan. Springs have the right stiffness only in the mean, and keep the strip wide where it is clamped.
    const double allowed = isTriangles(variant) ? (variant.sampling == Sampling::kScanned ? 0.03 : 1e-3) : 0.25;
    EXPECT_LT(a.error, allowed) << describe(problem, variant);
  }
}

TEST(Hammock, HangsAsAnElasticCatenary) {
  const Problem problem = findProblem(listHanging(), "hammock");
  for (const Variant& variant : problem.variants) {
    const std::vector<Answer> answers = ask(problem, variant, 2);
    // The finest resolution has twenty points along the cable. A chord is shorter than its arc by the square of the spacing.
    EXPECT_LT(answers[1].error, isTriangles(variant) ? 0.01 : 0.06) << describe(problem, variant);
    if (isTriangles(variant)) {
      EXPECT_GT(fitOrder(answers).value, 1.2) << describe(problem, variant);
    }
  }
}

}  // namespace
}  // namespace deformable_surface::physics
