#include "deformable_surface/tool/crossing.h"

#include "support/meshes.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using geometry::Solid;
using tool::Entry;
using tool::findCrossing;

Solid plate(double thickness) {
  Solid solid;
  solid.kind = Solid::Kind::kBox;
  solid.size = Vec3(1.0, 1.0, thickness);
  return solid;
}

TEST(Crossing, NoPlateIsTooThinAndNoWayTooLong) {
  for (double thickness : {0.1, 1e-3, 1e-6, 1e-9})
    for (double way : {0.2, 2.0, 200.0}) {
      const std::optional<Entry> entry = findCrossing(plate(thickness), Vec3(0.1, 0.2, 0.15), Vec3(0.1, 0.2, 0.15 - way));
      ASSERT_TRUE(entry) << thickness << " " << way;
      EXPECT_NEAR(entry->place.z(), 0.5 * thickness, 1e-9 * way + 1e-15);
      EXPECT_EQ(entry->normal, Vec3::UnitZ());
    }
}

TEST(Entry, OfEverySolidAndFromEverySideIsWhereTheWayMeetsIt) {
  Solid ball, mesh, cylinder;
  ball.radius = cylinder.radius = 0.3;
  cylinder.kind = Solid::Kind::kCylinder;
  cylinder.height = 0.4;
  mesh.kind = Solid::Kind::kMesh;
  const Mesh sphere = makeSphereMesh(0.3, 2);
  ASSERT_EQ(geometry::setMesh(sphere.vertices, geometry::toRows(sphere.triangles), mesh), "");
  for (const Solid& solid : {ball, mesh, cylinder, plate(0.05)})
    for (const Vec3& side : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0.1, 0.2), Vec3(0.1, -1, 0.1)}) {
      const std::optional<Entry> entry = tool::findEntry(solid, 2.0 * side, -2.0 * side);
      ASSERT_TRUE(entry);
      EXPECT_NEAR(geometry::findSignedDistance(solid, entry->place).distance, 0.0, 1e-8);
      EXPECT_GT(entry->normal.dot(side), 0.0);
    }
}

TEST(Crossing, WhatTheSolidPushesBackByItselfIsNone) {
  Solid ball;
  ball.radius = 0.3;
  EXPECT_FALSE(findCrossing(ball, Vec3(0, 0, 0.4), Vec3(0, 0, 0.31)));     // stays outside
  EXPECT_FALSE(findCrossing(ball, Vec3(0, 0, 0.4), Vec3(0, 0, 0.1)));      // in, and out again the same way
  EXPECT_TRUE(findCrossing(ball, Vec3(0, 0, 0.4), Vec3(0, 0, -0.1)));      // beyond the middle
  EXPECT_FALSE(findCrossing(ball, Vec3(0, 0, 0.28), Vec3(0, 0.02, 0.2)));  // inside all the time
  EXPECT_TRUE(findCrossing(ball, Vec3(0, 0, 0.28), Vec3(0, 0.02, -0.5)));
  EXPECT_FALSE(findCrossing(ball, Vec3(0.4, 0, 0.4), Vec3(0.4, 0, -0.4)));  // past it
  Solid plane;
  plane.kind = Solid::Kind::kPlane;
  EXPECT_FALSE(findCrossing(plane, Vec3(0, 0, 1.0), Vec3(0, 0, -50.0)));
}

TEST(Crossing, AWayThatOnlyCutsACornerIsNone) {
  // In by the upper side, out by the one beside it: no part of the plate is above the point then.
  EXPECT_FALSE(findCrossing(plate(0.1), Vec3(0.45, 0.0, 0.1), Vec3(0.6, 0.0, -0.1)));
}

TEST(Crossing, APointIsHeldUpUntilItIsInFrontOrBeside) {
  const Solid solid = plate(0.01);
  const Entry entry{Vec3(0.0, 0.0, 0.005), Vec3::UnitZ()};
  const auto isHeldUp = [&](const Vec3& p) { return tool::isHeldUp(solid, entry, p, geometry::findSignedDistance(solid, p)); };
  EXPECT_TRUE(isHeldUp(Vec3(0.2, 0.1, -3.0)));
  EXPECT_TRUE(isHeldUp(Vec3(0.2, 0.1, 0.0)));
  EXPECT_FALSE(isHeldUp(Vec3(0.2, 0.1, 0.006)));
  EXPECT_FALSE(isHeldUp(Vec3(0.51, 0.1, -3.0)));
}

}  // namespace
}  // namespace deformable_surface::test
