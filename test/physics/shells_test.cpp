// A shell of double curvature under point loads.
#include "series.h"

namespace deformable_surface::physics {
namespace {

TEST(Hemisphere, IsWithinAFewTensOfAPerCentOnCoarsePointsAndTooStiffWithTheFullRigidity) {
  const Problem reduced = findProblem(listShells(), "hemisphere, tenth of the load");
  const Problem full = findProblem(listShells(), "hemisphere, tenth of the load, D as published");
  for (const Variant& variant : reduced.variants) {
    // Eight points along a quarter of the equator: what is left is the point loads, which act on the area of one point.
    EXPECT_LT(ask(reduced, variant, 1)[0].error, 0.15) << describe(reduced, variant);
  }
  // The model bends with Poisson's ratio 0: with the published rigidity a shell that bends without stretching is 1 / (1 - nu)
  // too stiff.
  const Answer stiff = ask(full, full.variants[0], 1)[0];
  EXPECT_LT(stiff.value, 0.92 * stiff.reference);
}

}  // namespace
}  // namespace deformable_surface::physics
