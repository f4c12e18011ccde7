// Surfaces in contact: a ring pressed flat, and a strip pulled over a cylinder.
#include "series.h"

namespace deformable_surface::physics {
namespace {

TEST(PressedRing, NeedsThePressureOfTheElastica) {
  // Thirty points in a quarter of the ring.
  const Problem problem = findProblem(listContacts(), "pressed ring, half height 0.6 R");
  for (const Variant& variant : problem.variants)
    EXPECT_LT(ask(problem, variant, 1)[0].error, 0.01) << describe(problem, variant);
}

TEST(PressedRing, PressesItsHalvesTogetherAsTheElastica) {
  // The error falls with the square of the spacing, to 0.7 % with fifty points in a quarter.
  const Problem problem = findProblem(listContacts(), "pressed ring, force of contact at 6.3");
  for (const Variant& variant : problem.variants)
    EXPECT_LT(ask(problem, variant, 1)[0].error, 0.02) << describe(problem, variant);
}

TEST(Capstan, AStripBeginsToSlideAtTheRatioOfEuler) {
  const Problem problem = findProblem(listContacts(), "capstan, friction 0.3");
  for (const Variant& variant : problem.variants)
    EXPECT_LT(ask(problem, variant, 1)[0].error, 0.01) << describe(problem, variant);
}

}  // namespace
}  // namespace deformable_surface::physics
