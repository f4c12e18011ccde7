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

// The radius of contact is 0.06 m: 2.5, 3 and 4 spacings.
TEST(PressedBall, FeelsHertzsForce) {
  const Problem ball = findProblem(listSolids(), "ball pressed into a solid layer");
  for (const Variant& variant : ball.variants)
    for (const Answer& answer : ask(ball, variant, 3)) EXPECT_LT(answer.error, 0.03) << describe(ball, variant);
}

// A ball of 15 mm, 2 mm deep: the radius of contact is only 1.8 spacings, and a third of the ball's.
TEST(PalpatedSolid, IsNotSoftenedByContact) {
  const Problem finger = findProblem(listSolids(), "solid palpated by a ball");
  for (const Variant& variant : finger.variants) EXPECT_LT(ask(finger, variant, 1)[0].error, 0.2) << describe(finger, variant);
}

// The law that the theory of small strains is nearest to here: finite elements of it have 0.986 of the theory's force.
TEST(PalpatedSolid, FeelsHertzsForceByTheNeoHookeanLaw) {
  const Problem finger = findProblem(listSolids(), "neo-Hookean solid palpated by a ball");
  for (const Variant& variant : finger.variants) EXPECT_LT(ask(finger, variant, 1)[0].error, 0.1) << describe(finger, variant);
}

// With Poisson's ratio 0.3, where the penalty is softest compared with the body. As stiff as that of a sheet it takes a third.
TEST(PalpatedSolid, FeelsInMotionMostOfWhatItFeelsInEquilibrium) {
  const Problem moving = findProblem(listSolids(), "solid palpated by a ball, in motion");
  for (const Variant& variant : moving.variants) EXPECT_LT(ask(moving, variant, 1)[0].error, 0.15) << describe(moving, variant);
}

}  // namespace
}  // namespace deformable_surface::physics
