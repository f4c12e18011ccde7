#include "deformable_surface/geometry/solid.h"

#include <gtest/gtest.h>

#include <random>

namespace deformable_surface::test {
namespace {

using geometry::findSignedDistance;
using geometry::SignedDistance;
using geometry::Solid;

Solid make(Solid::Kind kind) {
  Solid solid;
  solid.kind = kind;
  solid.radius = 0.3;
  solid.height = 0.8;
  solid.size = Vec3(0.4, 0.6, 1.0);
  return solid;
}

const Solid::Kind kKinds[] = {Solid::Kind::kSphere, Solid::Kind::kBox, Solid::Kind::kCylinder, Solid::Kind::kCone,
                              Solid::Kind::kPlane};

Vec3 randomPoint(std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  return Vec3(u(random), u(random), u(random));
}

TEST(Solid, AStepOfTheDistanceAgainstTheNormalEndsOnTheSurface) {
  std::mt19937 random(1);
  for (Solid::Kind kind : kKinds)
    for (int k = 0; k < 1000; ++k) {
      const Solid solid = make(kind);
      const Vec3 p = randomPoint(random);
      const SignedDistance d = findSignedDistance(solid, p);
      EXPECT_NEAR(d.normal.norm(), 1.0, 1e-12);
      EXPECT_NEAR(findSignedDistance(solid, p - d.distance * d.normal).distance, 0.0, 1e-12)
          << static_cast<int>(kind) << " " << p.transpose();
    }
}

TEST(Solid, NoPointOfTheSurfaceIsNearerThanTheDistance) {
  // The distance changes by no more than the distance between two points, and takes every value between. It is then the distance
  // to the nearest point.
  std::mt19937 random(2);
  for (Solid::Kind kind : kKinds)
    for (int k = 0; k < 1000; ++k) {
      const Solid solid = make(kind);
      const Vec3 p = randomPoint(random), q = randomPoint(random);
      const double change = findSignedDistance(solid, p).distance - findSignedDistance(solid, q).distance;
      EXPECT_LE(std::abs(change), (p - q).norm() + 1e-12) << static_cast<int>(kind);
    }
}

TEST(Solid, KnownPointsHaveTheirDistance) {
  EXPECT_NEAR(findSignedDistance(make(Solid::Kind::kSphere), Vec3(0.0, 0.5, 0.0)).distance, 0.2, 1e-15);
  EXPECT_NEAR(findSignedDistance(make(Solid::Kind::kBox), Vec3(0.2 + 0.3, 0.3 + 0.4, 0.0)).distance, 0.5, 1e-15);
  EXPECT_NEAR(findSignedDistance(make(Solid::Kind::kBox), Vec3::Zero()).distance, -0.2, 1e-15);
  EXPECT_NEAR(findSignedDistance(make(Solid::Kind::kCylinder), Vec3(0.6, 0.0, 0.8)).distance, 0.5, 1e-15);
  EXPECT_NEAR(findSignedDistance(make(Solid::Kind::kCylinder), Vec3(0.0, 0.1, 0.3)).distance, -0.1, 1e-15);
  EXPECT_NEAR(findSignedDistance(make(Solid::Kind::kCone), Vec3(0.0, 0.0, 0.9)).distance, 0.5, 1e-15);
  EXPECT_NEAR(findSignedDistance(make(Solid::Kind::kCone), Vec3(0.1, 0.0, -0.9)).distance, 0.5, 1e-15);
  EXPECT_NEAR(findSignedDistance(make(Solid::Kind::kPlane), Vec3(3.0, 4.0, -0.1)).distance, -0.1, 1e-15);
}

TEST(Solid, APlaneLiesAcrossItsNormalAtItsOffset) {
  Solid plane = make(Solid::Kind::kPlane);
  plane.normal = Vec3(0.0, 3.0, 4.0);  // five long
  plane.offset = 0.5;
  // In units in the last place of numbers of about one.
  EXPECT_NEAR(findSignedDistance(plane, Vec3(7.0, 1.0, 1.0)).distance, 0.6 + 0.8 - 0.5, 1e-15);
  EXPECT_NEAR((findSignedDistance(plane, Vec3::Zero()).normal - Vec3(0.0, 0.6, 0.8)).norm(), 0.0, 1e-15);
}

TEST(Solid, TheMiddleOfASphereAndTheAxesHaveANormal) {
  for (Solid::Kind kind : kKinds)
    for (const Vec3& p : {Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.4), Vec3(0.0, 0.0, -0.4), Vec3(0.0, 0.0, 0.7)})
      EXPECT_NEAR(findSignedDistance(make(kind), p).normal.norm(), 1.0, 1e-12) << static_cast<int>(kind);
}

}  // namespace
}  // namespace deformable_surface::test
