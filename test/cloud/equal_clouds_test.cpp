#include "deformable_surface/cloud/equal_clouds.h"

#include <gtest/gtest.h>

#include <limits>

namespace deformable_surface::cloud {
namespace {

PointCloud makeCloud() {
  PointCloud cloud;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  cloud.positions = {{0.0, 1.0, 2.0}, {nan, nan, nan}};
  cloud.normals = {Vec3::UnitZ(), Vec3::UnitX()};
  cloud.extra_fields = {{"intensity", ScalarType::kUint8, 1, {3, 4}}};
  cloud.width = 2;
  cloud.viewpoint = Vec3(1.0, 0.0, 0.0);
  return cloud;
}

TEST(EqualClouds, AreSoToTheirCopiesHolesIncluded) { EXPECT_TRUE(areEqual(makeCloud(), makeCloud())); }

TEST(EqualClouds, DifferByAnythingThatTheyHold) {
  const PointCloud cloud = makeCloud();
  std::vector<PointCloud> others(8, cloud);
  others[0].positions[0].x() = 1e-300;
  others[1].normals.clear();
  others[2].extra_fields[0].bytes[1] = 5;
  others[3].extra_fields[0].name = "ring";
  others[4].viewpoint.reset();
  others[5].width = 1;
  others[6].positions.pop_back();
  others[7].origin.x() = 1.0;
  for (const PointCloud& other : others) EXPECT_FALSE(areEqual(cloud, other)) << &other - others.data();
}

}  // namespace
}  // namespace deformable_surface::cloud
