// Coulomb's friction with a spring.
#include "deformable_surface/contact/friction_law.h"

#include <gtest/gtest.h>

namespace deformable_surface::contact {
namespace {

const FrictionLaw kLaw{2.0, 1.5, 1e3, 5.0};
const Vec3 kStill = Vec3::Zero();

TEST(FrictionLaw, HoldsByItsSpringBelowTheLimit) {
  const Vec3 stretch(1e-3, 0.0, 0.0);
  EXPECT_TRUE(kLaw.findForce(stretch, kStill, false).isApprox(Vec3(-1.0, 0.0, 0.0)));
  Vec3 left = stretch;
  EXPECT_FALSE(kLaw.slide(left, kStill, false));
  EXPECT_EQ(left, stretch);
}

TEST(FrictionLaw, SlidesAtTheStaticLimitAndGoesOnWithTheKineticOne) {
  Vec3 stretch(0.0, 2.5e-3, 0.0);
  EXPECT_NEAR(kLaw.findForce(stretch, kStill, false).norm(), 2.0, 1e-12);
  EXPECT_TRUE(kLaw.slide(stretch, kStill, false));
  EXPECT_NEAR(stretch.y(), 1.5e-3, 1e-15);
  EXPECT_NEAR(kLaw.findForce(Vec3(0.0, 1.9e-3, 0.0), kStill, true).norm(), 1.5, 1e-12);
  // Below the kinetic limit it sticks again.
  Vec3 less(0.0, 1.4e-3, 0.0);
  EXPECT_FALSE(kLaw.slide(less, kStill, true));
}

TEST(FrictionLaw, ActsAgainstTheMotionOfWhatHasNoSpringYet) {
  EXPECT_TRUE(kLaw.findForce(kStill, Vec3(0.1, 0.0, 0.0), false).isApprox(Vec3(-0.5, 0.0, 0.0)));
  EXPECT_NEAR(kLaw.findForce(kStill, Vec3(9.0, 0.0, 0.0), false).norm(), 2.0, 1e-12);
}

TEST(FrictionLaw, KnowsTheEnergyOfItsSpring) {
  EXPECT_DOUBLE_EQ(kLaw.storedEnergy(Vec3(1e-3, 0.0, 0.0), kStill, false), 0.5e-3);
  // A spring that slackens: the damping hides a part of its force, so that it does not slide beyond the limit.
  const Vec3 stretch(3e-3, 0.0, 0.0), slackening(-0.4, 0.0, 0.0);
  EXPECT_DOUBLE_EQ(kLaw.storedEnergy(stretch, slackening, false), 4.5e-3);
  // One that slides keeps what the kinetic limit holds.
  EXPECT_NEAR(kLaw.storedEnergy(stretch, kStill, false), 0.5 * 1.5 * 1.5 / 1e3, 1e-15);
}

TEST(FrictionLaw, NothingPressedNothingHeld) {
  const FrictionLaw none{0.0, 0.0, 1e3, 5.0};
  EXPECT_EQ(none.findForce(Vec3(1e-3, 0.0, 0.0), Vec3(1.0, 0.0, 0.0), false), kStill);
  Vec3 stretch(1e-3, 0.0, 0.0);
  EXPECT_TRUE(none.slide(stretch, kStill, false));
  EXPECT_EQ(stretch, kStill);
}

}  // namespace
}  // namespace deformable_surface::contact
