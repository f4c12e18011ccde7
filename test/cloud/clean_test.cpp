// Cleaning keeps finite, distinct points in the order of the input. Every input point is mapped to its own.
#include "deformable_surface/cloud/clean.h"

#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace deformable_surface::cloud {
namespace {

PointCloud makeCloud(const Points& positions, const Points& normals = {}) {
  PointCloud cloud;
  cloud.positions = positions;
  cloud.normals = normals;
  cloud.width = static_cast<std::uint32_t>(positions.size());
  return cloud;
}

const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInf = std::numeric_limits<double>::infinity();

TEST(Clean, KeepsOrderAndNamesHolesAndCoincidentPoints) {
  const CleanCloud c =
      clean(makeCloud({{5, 0, 0}, {kNan, 0, 0}, {1, 2, 3}, {5, 0, 0}, {0, kInf, 0}, {-1, 0, 0}, {1, 2, 3}, {5, 0, 0}}));
  ASSERT_EQ(3u, c.positions.size());
  EXPECT_EQ(Vec3(5, 0, 0), c.positions[0]);
  EXPECT_EQ(Vec3(1, 2, 3), c.positions[1]);
  EXPECT_EQ(Vec3(-1, 0, 0), c.positions[2]);
  EXPECT_EQ((std::vector<Index>{0, -1, 1, 0, -1, 2, 1, 0}), c.point_of_input);
  EXPECT_EQ(2, c.num_not_finite);
  EXPECT_EQ(3, c.num_coincident);
  EXPECT_TRUE(c.normals.empty());
}

TEST(Clean, TakesNegativeZeroForZero) {
  const CleanCloud c = clean(makeCloud({{0.0, 1.0, 0.0}, {-0.0, 1.0, -0.0}}));
  EXPECT_EQ(1u, c.positions.size());
  EXPECT_EQ(1, c.num_coincident);
}

TEST(Clean, KeepsPointsThatDifferInTheLastBit) {
  const CleanCloud c = clean(makeCloud({{1.0, 0.0, 0.0}, {std::nextafter(1.0, 2.0), 0.0, 0.0}}));
  EXPECT_EQ(2u, c.positions.size());
}

TEST(Clean, TakesPointsBeyondTheLargestCoordinateForHoles) {
  const CleanCloud c = clean(makeCloud({{1e6, 0, 0}, {0, -1.0000001e6, 0}, {1e20, 1e20, 1e20}, {0, 0, 0}}));
  EXPECT_EQ((std::vector<Index>{0, -1, -1, 1}), c.point_of_input);
  EXPECT_EQ(2, c.num_not_finite);
}

TEST(Clean, NormalizesNormalsAndZeroesUnusableOnes) {
  const CleanCloud c = clean(makeCloud({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}},
                                       {{0, 0, 2}, {kNan, 0, 1}, {0, 0, 0}, {1e-200, 0, 0}, {0, -1e300, 0}}));
  ASSERT_EQ(5u, c.normals.size());
  EXPECT_EQ(Vec3(0, 0, 1), c.normals[0]);
  EXPECT_EQ(Vec3(0, 0, 0), c.normals[1]);
  EXPECT_EQ(Vec3(0, 0, 0), c.normals[2]);
  EXPECT_EQ(Vec3(1, 0, 0), c.normals[3]);
  EXPECT_EQ(Vec3(0, -1, 0), c.normals[4]);
}

TEST(Clean, TakesTheFirstUsableNormalAmongCoincidentPoints) {
  const CleanCloud c = clean(makeCloud({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 3, 0}, {1, 0, 0}}));
  ASSERT_EQ(1u, c.normals.size());
  EXPECT_EQ(Vec3(0, 1, 0), c.normals[0]);
}

TEST(Clean, AcceptsNothingAndNothingUsable) {
  EXPECT_TRUE(clean(makeCloud({})).positions.empty());
  const CleanCloud c = clean(makeCloud({{kNan, kNan, kNan}}, {{0, 0, 1}}));
  EXPECT_TRUE(c.positions.empty());
  EXPECT_EQ(std::vector<Index>{-1}, c.point_of_input);
}

TEST(Clean, TheTreeIsKeptAsLongAsThePointsStay) {
  CleanCloud c = clean(makeCloud({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  const std::shared_ptr<const KdTree> made = findTree(c);
  c.tree = made;
  EXPECT_EQ(made, findTree(c));
  c.positions[1].z() = 1e-9;
  EXPECT_NE(made, findTree(c));
  EXPECT_TRUE(findTree(c)->holds(c.positions));
}

TEST(Clean, RefusesWrongCountsAndLimits) {
  EXPECT_THROW(clean(makeCloud({{0, 0, 0}}, {{0, 0, 1}, {0, 0, 1}})), InputError);
  EXPECT_THROW(clean(makeCloud({{0, 0, 0}}), 0.0), InputError);
  EXPECT_THROW(clean(makeCloud({{0, 0, 0}}), kNan), InputError);
}

}  // namespace
}  // namespace deformable_surface::cloud
