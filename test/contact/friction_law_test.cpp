// Coulomb's friction with a spring.
#include "deformable_surface/contact/friction_law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::contact {
namespace {

const FrictionLaw kLaw{2.0, 1.5, 1e3, 5.0};
const Vec3 kStill = Vec3::Zero();
constexpr double kStep = 0.01;                                                   // s, in which the spring relaxes by two thirds
constexpr double kOnset = FrictionLaw::kOnset * 2.0 / 1e3, kAll = 2.0 * kOnset;  // m, the way D; more than that

TEST(FrictionLaw, HoldsByItsSpringBelowTheLimit) {
  const Vec3 stretch(1e-3, 0.0, 0.0);
  EXPECT_TRUE(kLaw.findForce(stretch, kStill, 0.0).isApprox(Vec3(-1.0, 0.0, 0.0)));
  Vec3 left = stretch;
  EXPECT_EQ(kLaw.slide(left, kStill, 0.0, kStep), 0.0);
  EXPECT_EQ(left, stretch);
}

TEST(FrictionLaw, SlidesAtTheStaticLimitAndGoesOnWithTheKineticOne) {
  Vec3 stretch(0.0, 2.5e-3, 0.0);
  EXPECT_NEAR(kLaw.findForce(stretch, kStill, 0.0).norm(), 2.0, 1e-12);
  const double slid = kLaw.slide(stretch, kStill, 0.0, kStep);
  // The spring relaxes towards the limit as far as its damper lets it, and the place slides by as much.
  EXPECT_NEAR(stretch.y(), (2.0 * 2.0e-3 + 1.0 * 2.5e-3) / 3.0, 1e-15);
  EXPECT_NEAR(slid, 2.5e-3 - stretch.y(), 1e-15);
  // The limit falls with the way.
  EXPECT_NEAR(kLaw.findForce(Vec3(0.0, 1.9e-3, 0.0), kStill, 0.5 * kOnset).norm(), 1.75, 1e-12);
  EXPECT_NEAR(kLaw.findForce(Vec3(0.0, 1.9e-3, 0.0), kStill, kAll).norm(), 1.5, 1e-12);
  for (int k = 0; k < 100; ++k) kLaw.slide(stretch, kStill, kAll, kStep);
  EXPECT_NEAR(stretch.y(), 1.5e-3, 1e-15);
  // Below the kinetic limit it sticks again.
  Vec3 less(0.0, 1.4e-3, 0.0);
  EXPECT_EQ(kLaw.slide(less, kStill, kAll, kStep), 0.0);
}

// The work of the force on the way of a step covers what the spring has gained, whatever the way and the limit.
TEST(FrictionLaw, MakesNoEnergy) {
  Vec3 stretch = kStill;
  double slid = 0.0;                  // m
  double spent = 0.0, largest = 0.0;  // J
  for (int k = 0; k < 1000; ++k) {
    FrictionLaw law = kLaw;
    law.static_limit = 1.0 + std::sin(0.37 * k);
    law.kinetic_limit = 0.7 * law.static_limit;
    const Vec3 sliding(0.4 * std::sin(0.05 * k), 0.3 * std::cos(0.11 * k), 0.0), before = stretch;
    stretch += kStep * sliding;
    const double work = -kStep * law.findForce(stretch, sliding, slid).dot(sliding);
    slid = law.slide(stretch, sliding, slid, kStep);
    const double gain = law.storedEnergy(stretch) - law.storedEnergy(before);
    EXPECT_LE(gain, work + 1e-12) << k;
    spent += work - gain;
    largest = std::max(largest, law.storedEnergy(stretch));
  }
  EXPECT_GT(spent, 0.0);
  EXPECT_GT(largest, 1e-4);
}

TEST(FrictionLaw, WhatBeginsFastSlidesFromTheBeginning) {
  EXPECT_EQ(kLaw.slidAtFirst(kStill), 0.0);
  EXPECT_LT(kLaw.slidAtFirst(Vec3(1e-3, 0.0, 0.0)), 0.1 * kOnset);
  EXPECT_GT(kLaw.slidAtFirst(Vec3(10.0, 0.0, 0.0)), kOnset);
  EXPECT_EQ(FrictionLaw{}.slidAtFirst(Vec3(1.0, 0.0, 0.0)), 0.0);
}

TEST(FrictionLaw, ActsAgainstTheMotionOfWhatHasNoSpringYet) {
  EXPECT_TRUE(kLaw.findForce(kStill, Vec3(0.1, 0.0, 0.0), 0.0).isApprox(Vec3(-0.5, 0.0, 0.0)));
  EXPECT_NEAR(kLaw.findForce(kStill, Vec3(9.0, 0.0, 0.0), 0.0).norm(), 2.0, 1e-12);
}

TEST(FrictionLaw, NothingPressedNothingHeld) {
  const FrictionLaw none{0.0, 0.0, 1e3, 5.0};
  EXPECT_EQ(none.findForce(Vec3(1e-3, 0.0, 0.0), Vec3(1.0, 0.0, 0.0), 0.0), kStill);
  Vec3 stretch(1e-3, 0.0, 0.0);
  EXPECT_GT(none.slide(stretch, kStill, 0.0, kStep), 0.0);
  EXPECT_NEAR(stretch.x(), 1e-3 / 3.0, 1e-15);  // the damper lets it go
}

}  // namespace
}  // namespace deformable_surface::contact
