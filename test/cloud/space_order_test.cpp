#include "deformable_surface/cloud/space_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace deformable_surface::cloud {
namespace {

constexpr int kSide = 200;

// A sheet in rows, and the position of each of its points in the input.
PointCloud makeSheet(bool is_shuffled) {
  PointCloud cloud;
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column)
      cloud.positions.emplace_back(0.01 * column, 0.01 * row, 0.1 * std::sin(0.05 * row));
  if (is_shuffled) std::shuffle(cloud.positions.begin(), cloud.positions.end(), std::mt19937(5));
  cloud.normals = cloud.positions;
  for (Vec3& normal : cloud.normals) normal = Vec3(normal.x(), normal.y(), 1.0).normalized();
  return cloud;
}

double findMedianStep(const Points& points) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < points.size(); ++i) steps.push_back((points[i] - points[i - 1]).norm());
  std::nth_element(steps.begin(), steps.begin() + steps.size() / 2, steps.end());
  return steps[steps.size() / 2];
}

TEST(SpaceOrder, LeavesRowsAsTheyAre) {
  CleanCloud cloud = clean(makeSheet(false));
  const Points before = cloud.positions;
  EXPECT_FALSE(orderInSpace(cloud));
  EXPECT_EQ(before, cloud.positions);
}

TEST(SpaceOrder, BringsNeighborsOfAShuffledSheetTogether) {
  const PointCloud input = makeSheet(true);
  CleanCloud cloud = clean(input);
  EXPECT_GT(findMedianStep(cloud.positions), 0.5);
  EXPECT_TRUE(orderInSpace(cloud));
  EXPECT_LT(findMedianStep(cloud.positions), 0.03);
  // Every point of the input is mapped to itself and its normal.
  for (std::size_t i = 0; i < input.positions.size(); ++i) {
    const Index point = cloud.point_of_input[i];
    ASSERT_EQ(input.positions[i], cloud.positions[point]);
    ASSERT_LT((input.normals[i] - cloud.normals[point]).norm(), 1e-12);
  }
}

TEST(SpaceOrder, KeepsHolesAndWhatCoincides) {
  PointCloud input = makeSheet(true);
  input.normals.clear();
  input.positions[7] = input.positions[20011];
  input.positions[8].x() = std::numeric_limits<double>::quiet_NaN();
  CleanCloud cloud = clean(input);
  ASSERT_TRUE(orderInSpace(cloud));
  EXPECT_EQ(cloud.point_of_input[8], -1);
  EXPECT_EQ(cloud.point_of_input[7], cloud.point_of_input[20011]);
  EXPECT_EQ(cloud.positions[cloud.point_of_input[7]], input.positions[7]);
  EXPECT_TRUE(cloud.normals.empty());
}

TEST(SpaceOrder, IsTheSameHoweverTheCloudWasShuffled) {
  CleanCloud one = clean(makeSheet(true));
  PointCloud other_input = makeSheet(true);
  std::reverse(other_input.positions.begin(), other_input.positions.end());
  std::reverse(other_input.normals.begin(), other_input.normals.end());
  CleanCloud other = clean(other_input);
  orderInSpace(one);
  orderInSpace(other);
  EXPECT_EQ(one.positions, other.positions);
}

}  // namespace
}  // namespace deformable_surface::cloud
