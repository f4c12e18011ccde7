// The bounding ball of a tool, the points within its reach, and points of its axis.
#include "../../src/simulation/tool_reach.h"

#include "support/meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {
namespace {

TEST(ToolReach, IsTheRadiusOfTheBallAboutTheOriginThatHoldsTheShape) {
  geometry::Solid shape;
  shape.kind = geometry::Solid::Kind::kSphere;
  shape.radius = 0.2;
  EXPECT_DOUBLE_EQ(findRadius(shape), 0.2);
  shape.kind = geometry::Solid::Kind::kBox;
  shape.size = Vec3(0.6, 0.8, 2.4);
  EXPECT_DOUBLE_EQ(findRadius(shape), 1.3);
  shape.kind = geometry::Solid::Kind::kPlane;
  EXPECT_TRUE(std::isinf(findRadius(shape)));
}

TEST(ToolReach, EndsWhereTheToolDoesAndWhileItDoesNotAct) {
  tool::ToolParams ball;
  ball.shape.kind = geometry::Solid::Kind::kSphere;
  ball.shape.radius = 0.1;
  ball.start = 1.0;
  ball.path = {{0.0, Vec3(1.0, 0.0, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)}};
  EXPECT_TRUE(isInReach(ball, 1.5, {Vec3::Zero(), Vec3(1.05, 0.0, 0.0)}));
  EXPECT_FALSE(isInReach(ball, 1.5, {Vec3::Zero(), Vec3(1.11, 0.0, 0.0)}));
  EXPECT_FALSE(isInReach(ball, 0.5, {Vec3(1.05, 0.0, 0.0)}));
  ball.mode = tool::Mode::kAttract;
  ball.reach = 0.5;
  EXPECT_TRUE(isInReach(ball, 1.5, {Vec3(1.55, 0.0, 0.0)}));
  EXPECT_FALSE(isInReach(ball, 1.5, {Vec3(1.65, 0.0, 0.0)}));
}

void expectNearlyTheSame(const geometry::Solid& shape, const test::Mesh& mesh, double tolerance) {
  geometry::Solid of_triangles;
  of_triangles.kind = geometry::Solid::Kind::kMesh;
  ASSERT_EQ(geometry::setMesh(mesh.vertices, geometry::toRows(mesh.triangles), of_triangles), "");
  const AxisPoints expected = listAxisPoints(shape), found = listAxisPoints(of_triangles);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) EXPECT_LT((found[k] - expected[k]).norm(), tolerance) << k;
}

TEST(ToolReach, AxisPointsOfAMeshAreThoseOfTheShapeThatItIs) {
  geometry::Solid box;
  box.kind = geometry::Solid::Kind::kBox;
  for (const Vec3& size : {Vec3(0.6, 0.8, 2.4), Vec3(0.003, 0.15, 0.003), Vec3(0.3, 0.3, 0.02), Vec3(1.0, 1.0, 1.0)}) {
    box.size = size;
    expectNearlyTheSame(box, test::makeBoxMesh(size), 1e-9);
  }
  geometry::Solid cylinder;
  cylinder.kind = geometry::Solid::Kind::kCylinder;
  cylinder.radius = 0.01;
  for (double height : {0.2, 0.02, 0.001}) {
    cylinder.height = height;
    expectNearlyTheSame(cylinder, test::makeCylinderMesh(0.01, height, 24), 0.001);
  }
}

TEST(ToolReach, AxisPointsOfASlimConeAreNearItsTipAndItsBase) {
  geometry::Solid cone;
  cone.kind = geometry::Solid::Kind::kCone;
  cone.height = 0.1;
  for (const auto& [radius, end] : {std::pair{0.001, 0.049}, {0.04, 0.025}}) {
    cone.radius = radius;
    const AxisPoints axis = listAxisPoints(cone);
    ASSERT_EQ(axis.size(), 3u);
    EXPECT_NEAR(axis[1].z(), end, 1e-12);
    EXPECT_NEAR(axis[2].z(), -end, 1e-12);
  }
}

TEST(ToolReach, FlatToolsThatAreThinHavePlacesNearAllEdges) {
  geometry::Solid shape;
  shape.kind = geometry::Solid::Kind::kBox;
  shape.size = Vec3(0.3, 0.002, 0.2);
  const EdgePlaces of_box = listEdgePlaces(shape, 0.02);
  const AxisPoints& places = of_box.places;
  ASSERT_EQ(places.size(), 8u);
  EXPECT_EQ(of_box.across, Vec3::UnitY());
  for (const double x : {0.0, 0.12, -0.12})
    for (const double z : {0.0, 0.07, -0.07})
      EXPECT_EQ(std::any_of(places.begin(), places.end(), [&](const Vec3& p) { return (p - Vec3(x, 0.0, z)).norm() < 1e-12; }),
                x != 0.0 || z != 0.0)
          << x << ' ' << z;

  shape.kind = geometry::Solid::Kind::kCylinder;
  shape.radius = 0.1;
  shape.height = 0.002;
  const EdgePlaces of_disc = listEdgePlaces(shape, 0.02);
  ASSERT_EQ(of_disc.places.size(), 8u);
  EXPECT_EQ(of_disc.across, Vec3::UnitZ());
  for (const Vec3& place : of_disc.places) {
    EXPECT_NEAR(place.norm(), 0.07, 1e-12);
    EXPECT_EQ(place.z(), 0.0);
  }
}

TEST(ToolReach, OtherToolsHaveNoPlacesNearEdges) {
  geometry::Solid shape;
  EXPECT_EQ(listEdgePlaces(shape, 0.02).places.size(), 0u);
  shape.kind = geometry::Solid::Kind::kBox;
  for (const Vec3& size : {Vec3(0.3, 0.03, 0.2), Vec3(0.3, 0.002, 0.05), Vec3(0.3, 0.002, 0.002)}) {
    shape.size = size;
    EXPECT_EQ(listEdgePlaces(shape, 0.02).places.size(), 0u) << size.transpose();
  }
}

}  // namespace
}  // namespace deformable_surface::simulation
