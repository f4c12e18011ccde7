// Membranes under pressure: the clamped disc of Hencky and the balloon.
#include "series.h"

namespace deformable_surface::physics {
namespace {

TEST(ClampedDisc, RisesUnderPressureAsHenckysMembrane) {
  const Problem problem = findProblem(listMembranes(), "clamped disc");
  for (const Variant& variant : problem.variants) {
    const std::vector<Answer> answers = ask(problem, variant, 2);
    // Ten points along the radius. Flat triangles miss the height of a dome by the square of the spacing: a few times a tenth of
    // a per cent.
    EXPECT_LT(answers[1].error, isTriangles(variant) ? 0.006 : 0.06) << describe(problem, variant);
    if (isTriangles(variant)) {
      EXPECT_GT(fitOrder(answers).value, 1.5) << describe(problem, variant);
    }
  }
}

TEST(Balloon, FollowsTheClosedFormWithTriangles) {
  const Problem problem = findProblem(listMembranes(), "balloon");
  for (const Variant& variant : problem.variants) {
    const std::vector<Answer> answers = ask(problem, variant, 2);
    // The polyhedron is smaller than the sphere by the square of spacing over radius. Springs are soft where the mesh is not
    // equilateral. Refinement does not change that.
    EXPECT_LT(answers[1].error, isTriangles(variant) ? 0.025 : 0.10) << describe(problem, variant);
    if (isTriangles(variant)) {
      EXPECT_NEAR(fitOrder(answers).value, 2.0, 0.3) << describe(problem, variant);
    }
  }
}

}  // namespace
}  // namespace deformable_surface::physics
