// A tool follows its marker at a limited speed, and jerks of the mouse lead nowhere.
#include "../../../src/ros/interactive_markers/marker_way.h"

#include "deformable_surface/base/types.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::node {
namespace {

constexpr double kLever = 0.2, kLoop = 0.01;

tool::Pose makePose(double x, double z, double turn = 0.0) {
  return {Vec3(x, 0.0, z), Eigen::Quaterniond(Eigen::AngleAxisd(turn, Vec3::UnitY()))};
}

TEST(MarkerWay, TakesTheDrawnWayAndNotTheShortestAtAnySpeedOfTheMouse) {
  MarkerWay way(makePose(0.0, 0.0), kLever, kLoop);
  way.append(makePose(0.0, 1.0));
  way.append(makePose(1.0, 1.0));
  way.append(makePose(1.0, 0.0));
  way.advance(0.5);
  EXPECT_LT((way.pose().position - Vec3(0.0, 0.0, 0.5)).norm(), 1e-12);
  way.advance(1.0);
  EXPECT_LT((way.pose().position - Vec3(0.5, 0.0, 1.0)).norm(), 1e-12);
  way.advance(1.0);
  EXPECT_LT((way.pose().position - Vec3(1.0, 0.0, 0.5)).norm(), 1e-12);
  EXPECT_FALSE(way.hasArrived());
  way.advance(1.0);
  EXPECT_LT((way.pose().position - Vec3(1.0, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_TRUE(way.hasArrived());
}

TEST(MarkerWay, ATurnTakesTheTimeThatAPointAtTheLeverTakes) {
  MarkerWay way(makePose(0.0, 0.0), kLever, kLoop);
  way.append(makePose(0.0, 0.0, 1.0));
  way.advance(0.25 * kLever);
  EXPECT_NEAR(way.pose().orientation.angularDistance(Eigen::Quaterniond::Identity()), 0.25, 1e-12);
  way.advance(0.75 * kLever + 1e-12);
  EXPECT_TRUE(way.hasArrived());
}

TEST(MarkerWay, LeavesOutWhatReturnsToWhereItWas) {
  MarkerWay way(makePose(0.0, 0.0), kLever, kLoop);
  way.append(makePose(0.0, 0.1));
  way.append(makePose(5.0, 3.0));
  way.append(makePose(9.0, -3.0));
  way.append(makePose(0.0, 0.105));
  way.append(makePose(0.0, 0.2));
  way.advance(0.2 + 1e-12);
  EXPECT_TRUE(way.hasArrived());
  // Back to where the tool is itself.
  way.append(makePose(5.0, 0.2));
  way.append(makePose(0.0, 0.2));
  way.advance(1e-3);
  EXPECT_TRUE(way.hasArrived());
  EXPECT_LT((way.pose().position - Vec3(0.0, 0.0, 0.2)).norm(), 1e-12);
}

TEST(MarkerWay, FollowsSmallStepsOfTheMouseOnACircle) {
  MarkerWay way(makePose(0.0, 0.0), kLever, kLoop);
  constexpr int kSteps = 2000;
  for (int i = 1; i <= kSteps; ++i) way.append(makePose(1.0 - std::cos(kPi * i / kSteps), std::sin(kPi * i / kSteps)));
  double farthest = 0.0;
  for (int i = 0; i < 5 * kSteps && !way.hasArrived(); ++i) {
    way.advance(kPi / kSteps);
    farthest = std::max(farthest, std::abs((way.pose().position - Vec3(1.0, 0.0, 0.0)).norm() - 1.0));
  }
  EXPECT_TRUE(way.hasArrived());
  EXPECT_LT(farthest, kLoop);
}

}  // namespace
}  // namespace deformable_surface::node
