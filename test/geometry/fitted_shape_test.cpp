#include "deformable_surface/geometry/fitted_shape.h"

#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace deformable_surface::test {
namespace {

using geometry::FittedShape;

const double kTurn = 2.0 * std::acos(-1.0);

// Points of a torus about an axis that is no coordinate axis, alternately `off` outside and inside of it.
Points makeTorus(double ring, double tube, double off) {
  const Quaternion turn(Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 0.5).normalized()));
  Points points;
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 20; ++j) {
      const double u = kTurn * i / 40, v = kTurn * j / 20, r = tube + ((i + j) % 2 == 0 ? off : -off);
      const Vec3 p((ring + r * std::cos(v)) * std::cos(u), (ring + r * std::cos(v)) * std::sin(u), r * std::sin(v));
      points.push_back(Vec3(1.0, -2.0, 3.0) + turn * p);
    }
  return points;
}

Points makeSphere(double radius, double off, double lowest) {
  Points points;
  for (int i = 0; i < 400; ++i) {
    const double z = 1.0 - (1.0 - lowest) * (i + 0.5) / 400, angle = 2.399963 * i, across = std::sqrt(1.0 - z * z);
    const Vec3 outward(across * std::cos(angle), across * std::sin(angle), z);
    points.push_back(Vec3(5.0, 0.0, -1.0) + (radius + (i % 2 == 0 ? off : -off)) * outward);
  }
  return points;
}

TEST(FittedShape, IsTheTorusThatPointsLieOn) {
  const FittedShape found = geometry::fitTorus(makeTorus(0.4, 0.15, 0.0));
  EXPECT_NEAR(found.radius, 0.4, 1e-12);
  EXPECT_NEAR(found.tube_radius, 0.15, 1e-12);
  EXPECT_LT(found.largest, 1e-12);
}

// At every place as many points are outside as inside. The shape is still the nearest.
TEST(FittedShape, TellsHowFarPointsAreFromIt) {
  const FittedShape torus = geometry::fitTorus(makeTorus(0.4, 0.15, 0.01));
  EXPECT_NEAR(torus.radius, 0.4, 1e-9);
  EXPECT_NEAR(torus.tube_radius, 0.15, 1e-9);
  EXPECT_NEAR(torus.root_mean_square, 0.01, 1e-9);
  EXPECT_NEAR(torus.largest, 0.01, 1e-9);
  const FittedShape sphere = geometry::fitSphere(makeSphere(0.3, 0.01, -1.0));
  EXPECT_NEAR(sphere.radius, 0.3, 1e-4);  // neighbours of a spiral are not in the same place
  EXPECT_NEAR(sphere.root_mean_square, 0.01, 1e-4);
  EXPECT_EQ(sphere.tube_radius, 0.0);
}

TEST(FittedShape, IsFoundFromAPartOfASphere) {
  const FittedShape cap = geometry::fitSphere(makeSphere(0.3, 0.0, 0.7));
  EXPECT_NEAR(cap.radius, 0.3, 1e-9);
  EXPECT_LT(cap.largest, 1e-9);
}

TEST(FittedShape, RefusesTooFewPointsAndSuchAsAreNotFinite) {
  Points points = makeTorus(0.4, 0.15, 0.0);
  EXPECT_THROW(geometry::fitTorus(Points(points.begin(), points.begin() + 6)), InputError);
  EXPECT_THROW(geometry::fitSphere(Points(points.begin(), points.begin() + 3)), InputError);
  points[5].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(geometry::fitTorus(points), InputError);
  EXPECT_THROW(geometry::fitSphere(points), InputError);
}

}  // namespace
}  // namespace deformable_surface::test
