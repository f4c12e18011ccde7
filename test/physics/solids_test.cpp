// Elastic solids against Timoshenko's beam and the pressed ball, at coarse resolutions.
#include "series.h"

namespace deformable_surface::physics {
namespace {

// The clamp of the beam lets the end contract, that of the bar does not. With jitter the bar is stiffer by another two per cent.
TEST(SolidBar, SinksAsTimoshenkosBeam) {
  const Problem bar = findProblem(listSolids(), "solid bar under its weight");
  for (const Variant& variant : bar.variants)
    for (const Answer& answer : ask(bar, variant, 2))
      EXPECT_LT(answer.error, 0.05) << describe(bar, variant) << ", " << answer.size;
}

// The radius of contact is 0.06 m: 2.5, 3 and 4 spacings. The spacing decides which points touch, so the force is uncertain by
// some of its square.
TEST(PressedBall, FeelsHertzsForceAndBetterWithMorePoints) {
  const Problem ball = findProblem(listSolids(), "ball pressed into a solid layer");
  for (const Variant& variant : ball.variants) {
    const std::vector<Answer> answers = ask(ball, variant, 3);
    EXPECT_LT(answers[0].error, 0.12) << describe(ball, variant);
    EXPECT_LT(answers[1].error, 0.08) << describe(ball, variant);
    EXPECT_LT(answers[2].error, 0.05) << describe(ball, variant);
    EXPECT_LT(answers[2].error, 0.5 * answers[0].error) << describe(ball, variant);
  }
}

}  // namespace
}  // namespace deformable_surface::physics
