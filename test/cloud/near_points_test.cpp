// Points nearer to each other than a hundredth of the spacing around become one, whatever their order; others stay.
#include "deformable_surface/cloud/near_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_surface::cloud {
namespace {

constexpr Index kSide = 20;
constexpr double kSpacing = 0.05;

Points makeGrid() {
  Points points;
  for (Index i = 0; i < kSide; ++i)
    for (Index j = 0; j < kSide; ++j) points.emplace_back(kSpacing * i, kSpacing * j, 0.0);
  return points;
}

CleanCloud cleanPoints(const Points& positions, const Points& normals = {}) {
  PointCloud cloud;
  cloud.positions = positions;
  cloud.normals = normals;
  cloud.width = static_cast<std::uint32_t>(positions.size());
  return clean(cloud);
}

// Copies of every point, each moved in its own direction.
Points copyMoved(const Points& points, int copies, double distance) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Points moved = points;
  for (int c = 0; c < copies; ++c)
    for (const Vec3& p : points)
      moved.push_back(p + distance * Vec3(normal(random), normal(random), normal(random)).normalized());
  return moved;
}

TEST(NearPoints, FindTheSpacingWherePointsAreThereSeveralTimes) {
  for (const int copies : {0, 1, 3, 6})
    EXPECT_NEAR(kSpacing, findTypicalSpacing(copyMoved(makeGrid(), copies, 1e-9)), 1e-8) << copies << " copies";
}

TEST(NearPoints, MergeWithTheirGroup) {
  for (const int copies : {1, 3, 6}) {
    const Points grid = makeGrid();
    CleanCloud cloud = cleanPoints(copyMoved(grid, copies, 1e-9));
    const NearPoints near = mergeNearPoints(cloud);
    ASSERT_EQ(grid.size(), cloud.positions.size()) << copies << " copies";
    EXPECT_EQ(static_cast<Index>(grid.size()) * copies, near.num_merged);
    EXPECT_GT(near.distance, 0.0);
    EXPECT_LE(near.distance, 2.001e-9);
    for (std::size_t i = 0; i < cloud.point_of_input.size(); ++i)
      EXPECT_EQ(static_cast<Index>(i % grid.size()), cloud.point_of_input[i]);
  }
}

TEST(NearPoints, StayWhereTheyAreInAnyOrder) {
  Points points = copyMoved(makeGrid(), 2, 1e-9);
  std::mt19937 random(2);
  CleanCloud first = cleanPoints(points);
  mergeNearPoints(first);
  for (int trial = 0; trial < 5; ++trial) {
    std::vector<Index> order(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Index>(i);
    std::shuffle(order.begin(), order.end(), random);
    Points shuffled;
    for (const Index i : order) shuffled.push_back(points[i]);
    CleanCloud cloud = cleanPoints(shuffled);
    mergeNearPoints(cloud);
    ASSERT_EQ(first.positions.size(), cloud.positions.size());
    for (std::size_t i = 0; i < order.size(); ++i)
      EXPECT_EQ(first.positions[first.point_of_input[order[i]]], cloud.positions[cloud.point_of_input[i]]);
  }
}

TEST(NearPoints, TakeTheFirstNormalThatIsOne) {
  Points points = makeGrid(), normals(points.size(), Vec3::UnitZ());
  points.insert(points.begin(), points[7] + Vec3(1e-9, 0, 0));
  normals.insert(normals.begin(), Vec3::Zero());
  CleanCloud cloud = cleanPoints(points, normals);
  EXPECT_EQ(1, mergeNearPoints(cloud).num_merged);
  ASSERT_EQ(cloud.positions.size(), cloud.normals.size());
  EXPECT_EQ(0, cloud.point_of_input[8]);
  EXPECT_EQ(Vec3(Vec3::UnitZ()), cloud.normals[0]);
  EXPECT_EQ(makeGrid()[7], cloud.positions[0]);
}

TEST(NearPoints, MergeNoneThatAreFartherThanAHundredthOfTheSpacing) {
  const Points points = copyMoved(makeGrid(), 1, 0.011 * kSpacing);
  CleanCloud cloud = cleanPoints(points);
  const NearPoints near = mergeNearPoints(cloud);
  EXPECT_EQ(0, near.num_merged);
  EXPECT_EQ(0.0, near.spacing);
  EXPECT_EQ(points, cloud.positions);
}

// The same scan twice, in a frame that is not along its rows, the second time rounded.
TEST(NearPoints, MergeWhateverTheyAreRoundedTo) {
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, 3).normalized());
  Points grid = makeGrid();
  for (Vec3& p : grid) p = turn * p + Vec3(0.123456789, 0.23456789, 0.3456789);
  for (const double digit : {1e-6, 1e-5, 1e-4, 4e-4}) {
    Points points = grid;
    for (const Vec3& p : grid) points.push_back((p / digit).array().round() * digit);
    CleanCloud cloud = cleanPoints(points);
    EXPECT_EQ(static_cast<Index>(grid.size()), mergeNearPoints(cloud).num_merged) << digit;
    for (std::size_t i = 0; i < grid.size(); ++i) EXPECT_EQ(cloud.point_of_input[i], cloud.point_of_input[i + grid.size()]);
  }
  Points points = grid;
  for (const Vec3& p : grid) points.push_back(p.cast<float>().cast<double>());
  CleanCloud cloud = cleanPoints(points);
  EXPECT_EQ(static_cast<Index>(grid.size()), mergeNearPoints(cloud).num_merged);
}

// A part that is a thousand times finer than the rest.
TEST(NearPoints, StayWhereTheCloudIsFine) {
  Points points = makeGrid();
  for (Index i = 0; i < 10; ++i)
    for (Index j = 0; j < 10; ++j) points.emplace_back(kSpacing * (5.3 + 1e-3 * i), kSpacing * (5.3 + 1e-3 * j), 0.0);
  CleanCloud cloud = cleanPoints(points);
  EXPECT_EQ(0, mergeNearPoints(cloud).num_merged);
  EXPECT_EQ(points, cloud.positions);
}

TEST(NearPoints, AreFewAmongPointsAtRandom) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Points points;
  for (int i = 0; i < 100000; ++i) points.emplace_back(uniform(random), uniform(random), 0.0);
  CleanCloud cloud = cleanPoints(points);
  EXPECT_LE(mergeNearPoints(cloud).num_merged, 10);
}

TEST(NearPoints, MergeWhereverTheyLie) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    Points points;
    for (int i = 0; i < 300; ++i) points.emplace_back(uniform(random), uniform(random), trial % 2 ? uniform(random) : 0.0);
    const Vec3 moved = Vec3(uniform(random), uniform(random), uniform(random)) * 1e-9;
    points.push_back(points[trial] + moved);
    CleanCloud cloud = cleanPoints(points);
    EXPECT_GE(mergeNearPoints(cloud).num_merged, 1) << trial;
    EXPECT_EQ(cloud.point_of_input[trial], cloud.point_of_input.back()) << trial;
  }
}

TEST(NearPoints, OfAHeapBecomeOne) {
  Points points = makeGrid();
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1e-8, 1e-8);
  for (int i = 0; i < 300; ++i) points.push_back(points[33] + Vec3(uniform(random), uniform(random), uniform(random)));
  CleanCloud cloud = cleanPoints(points);
  EXPECT_EQ(300, mergeNearPoints(cloud).num_merged);
}

TEST(NearPoints, AreNotSoughtAmongNoneOrOne) {
  CleanCloud none = cleanPoints({}), one = cleanPoints({{1, 2, 3}});
  EXPECT_EQ(0, mergeNearPoints(none).num_merged);
  EXPECT_EQ(0, mergeNearPoints(one).num_merged);
  EXPECT_EQ(0.0, findTypicalSpacing({{1, 2, 3}}));
}

}  // namespace
}  // namespace deformable_surface::cloud
