// On which triangles of a surface places of another triangle lie.
#include "../../src/simulation/triangles_beneath.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using contact::Triangle;

// Two triangles of a square, the first of them again 0.05 higher, and one far above.
const Points kPoints = {Vec3(0, 0, 0),    Vec3(1, 0, 0),    Vec3(1, 1, 0),   Vec3(0, 1, 0),   Vec3(0, 0, 0.05),
                        Vec3(1, 0, 0.05), Vec3(1, 1, 0.05), Vec3(0, 0, 0.5), Vec3(1, 0, 0.5), Vec3(1, 1, 0.5)};
const Triangle kLow = {0, 1, 2}, kBeside = {0, 2, 3}, kHigher = {4, 5, 6}, kFar = {7, 8, 9};

TEST(TrianglesBeneath, TheNearestThatFacesTheSameWayIsFound) {
  const std::vector<Triangle> surface = {kLow, kBeside, kHigher, kFar};
  const simulation::TrianglesBeneath beneath(kPoints, surface);
  Triangle found;
  const auto findAt = [&](const Triangle& t, const Vec3& place) { return beneath.find(t, place, found); };
  ASSERT_TRUE(findAt(kLow, Vec3(0.6, 0.3, 0.02)));
  EXPECT_EQ(found, kLow);
  ASSERT_TRUE(findAt(kLow, Vec3(0.6, 0.3, 0.03)));
  EXPECT_EQ(found, kHigher);
  ASSERT_TRUE(findAt(kLow, Vec3(0.3, 0.6, 0.03)));
  EXPECT_EQ(found, kBeside);
  EXPECT_FALSE(findAt({0, 2, 1}, Vec3(0.6, 0.3, 0.02))) << "the other side";
  EXPECT_FALSE(findAt(kLow, Vec3(0.6, 0.3, 0.25))) << "too far above";
  EXPECT_FALSE(findAt(kLow, Vec3(0.6, -0.05, 0.0))) << "beside";
}

TEST(TrianglesBeneath, PlacesLieWithinTheTriangle) {
  for (const Vec3& place : simulation::listPlaces(kPoints, kFar)) {
    EXPECT_NEAR(place.z(), 0.5, 1e-15);
    EXPECT_GT(place.y(), 0.1);
    EXPECT_GT(place.x() - place.y(), 0.1);
    EXPECT_LT(place.x(), 0.9);
  }
}

}  // namespace
}  // namespace deformable_surface::test
