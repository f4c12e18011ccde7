#include "deformable_surface/geometry/point_boxes.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace deformable_surface::test {
namespace {

using geometry::PointBoxes;

// Points along a line, with noise.
Points makePoints(Index count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(-0.02, 0.02);
  Points points;
  for (Index i = 0; i < count; ++i) points.emplace_back(0.01 * static_cast<double>(i) + u(random), u(random), u(random));
  return points;
}

TEST(PointBoxes, NoPointOfABallIsSkippedAndMostOthersAre) {
  const Points points = makePoints(500);
  PointBoxes boxes;
  boxes.update(makePoints(700));
  boxes.update(points);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> x(-1.0, 6.0), aside(-0.1, 0.1);
  Index num_inside = 0, num_looked = 0;
  for (int k = 0; k < 200; ++k) {
    const Vec3 centre(x(random), aside(random), aside(random));
    const double radius = std::abs(aside(random));
    for (Index i = 0; i < 500; ++i) {
      const bool may_meet = boxes.mayMeet(i / PointBoxes::kRun, centre, radius);
      num_looked += may_meet;
      if (!((points[i] - centre).norm() <= radius)) continue;
      ++num_inside;
      EXPECT_TRUE(may_meet);
      EXPECT_TRUE(boxes.mayMeet(centre, radius));
    }
  }
  EXPECT_GT(num_inside, 100);
  EXPECT_LT(num_looked, 200 * 500 / 10);
  EXPECT_FALSE(boxes.mayMeet(Vec3(0.0, 1.0, 0.0), 0.9));
}

TEST(PointBoxes, APlaneMeetsAllAndNoPointsAreMetByNothing) {
  PointBoxes boxes;
  boxes.update(makePoints(40));
  EXPECT_TRUE(boxes.mayMeet(1, Vec3(1e9, 0.0, 0.0), std::numeric_limits<double>::infinity()));
  boxes.update({});
  EXPECT_FALSE(boxes.mayMeet(Vec3::Zero(), 1.0));
}

}  // namespace
}  // namespace deformable_surface::test
