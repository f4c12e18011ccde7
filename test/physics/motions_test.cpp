// Checks for every material: free fall and conservation laws.
#include "series.h"

namespace deformable_surface::physics {
namespace {

TEST(FreeFall, IsExactWithVerletAndTheImplicitMethodAndOfFirstOrderWithSymplecticEuler) {
  const std::vector<Problem> problems = listMotions();
  const Variant variant = problems[0].variants[0];
  // Verlet integrates a constant acceleration without error. The remaining error is rounding, added up over the steps.
  for (const Answer& a : ask(findProblem(problems, "free fall, verlet"), variant, 3)) EXPECT_LT(a.error, 1e-12);
  // So does the implicit method, up to the tolerance of its equations.
  for (const Answer& a : ask(findProblem(problems, "free fall, implicit"), variant, 3)) EXPECT_LT(a.error, 1e-7);
  // Symplectic Euler is late by half a step: g t dt / 2, a share dt / t of the distance.
  for (const Answer& a : ask(findProblem(problems, "free fall, symplectic_euler"), variant, 3))
    EXPECT_NEAR(a.error, a.size / 0.48, 1e-6);
}

TEST(TumblingSheet, KeepsItsMomentaToRoundingInEverySampling) {
  for (const char* name : {"momentum of a tumbling sheet", "angular momentum of a tumbling sheet"}) {
    const Problem problem = findProblem(listMotions(), name);
    // A thousand steps, each with rounding errors of about 1e-16 that add up like a random walk.
    for (const Variant& variant : problem.variants)
      for (const Answer& a : ask(problem, variant, 3)) EXPECT_LT(a.error, 1e-12) << describe(problem, variant);
  }
}

TEST(TumblingSheet, KeepsItsEnergyWithTheSquareOfTheStep) {
  const Problem problem = findProblem(listMotions(), "energy of a tumbling sheet");
  const std::vector<Answer> answers = ask(problem, problem.variants[0], 3);
  EXPECT_NEAR(fitOrder(answers).value, 2.0, 0.1);
  EXPECT_LT(answers.back().error, 1e-5);
}

}  // namespace
}  // namespace deformable_surface::physics
