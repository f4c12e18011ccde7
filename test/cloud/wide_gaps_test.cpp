// Wide gaps against sorted angles.
#include "../../src/cloud/wide_gaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace deformable_surface::cloud {
namespace {

constexpr double kFullTurn = 6.28318530717958648;

double findWidest(std::vector<double> angles) {
  std::sort(angles.begin(), angles.end());
  double widest = angles.front() + kFullTurn - angles.back();
  for (std::size_t a = 1; a < angles.size(); ++a) widest = std::max(widest, angles[a] - angles[a - 1]);
  return widest;
}

TEST(WideGaps, AreThereAsLongAsSortedAnglesLeaveOne) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int num_closed = 0;
  for (const double limit : {2.3, 2.8}) {
    WideGaps gaps(limit);
    for (int trial = 0; trial < 1000; ++trial) {
      gaps.clear();
      EXPECT_FALSE(gaps.isEmpty());
      std::vector<double> angles;
      for (int k = 0; k < 12; ++k) {
        const double angle = kFullTurn * unit(random), length = 0.01 + unit(random);
        angles.push_back(angle);
        gaps.add(length * Vec2(std::cos(angle), std::sin(angle)));
        ASSERT_EQ(gaps.isEmpty(), findWidest(angles) <= limit) << trial << ", " << k;
      }
      num_closed += gaps.isEmpty();
    }
  }
  EXPECT_GT(num_closed, 1000);
  EXPECT_LT(num_closed, 2000);
}

TEST(WideGaps, StayAFullTurnWithOneDirection) {
  WideGaps gaps(2.3);
  for (const Vec2& q : {Vec2(0.0, 0.0), Vec2(1.0, 2.0), Vec2(2.0, 4.0), Vec2(0.0, 0.0), Vec2(1.0, 2.0)}) {
    gaps.add(q);
    EXPECT_FALSE(gaps.isEmpty());
  }
}

TEST(WideGaps, AreNoneOnTheAxes) {
  WideGaps gaps(2.3);
  for (const Vec2& q : {Vec2(1.0, 0.0), Vec2(0.0, 2.0), Vec2(-1.0, 0.0)}) gaps.add(q);
  EXPECT_FALSE(gaps.isEmpty());
  gaps.add(Vec2(0.0, -3.0));
  EXPECT_TRUE(gaps.isEmpty());
}

}  // namespace
}  // namespace deformable_surface::cloud
