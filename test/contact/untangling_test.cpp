// How crossed parts of a surface are pushed.
#include "deformable_surface/contact/untangling.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../support/crossings.h"
#include "folded_sheets.h"

namespace deformable_surface::contact {
namespace {

// The second of two sheets is narrower, is turned about y by an angle, and cuts through the first one.
test::Sheets makeCrossed(double angle, double aside, double along = 0.0) {
  test::Sheets sheets = test::makeSheets(2, 9, 0.0, 0.001);
  const Vec3 middle(0.05, 0.05, 0.0);
  const Mat3 turn = Eigen::AngleAxisd(angle, Vec3::UnitY()).toRotationMatrix();
  for (std::size_t i = 81; i < sheets.points.size(); ++i)
    sheets.points[i] = turn * Vec3(1.0, 0.7, 1.0).cwiseProduct(sheets.points[i] - middle) + middle + Vec3(0.0, along, aside);
  return sheets;
}

std::vector<Push> findPushes(const test::Sheets& sheets) {
  const PairList pairs(sheets.points, sheets.triangles, 0.001);
  return findPushes(pairs, sheets.points, std::vector<double>(sheets.points.size(), 1.0));
}

// Of the second sheet relative to the first.
Vec3 sumForces(const std::vector<Push>& pushes) {
  Vec3 sum = Vec3::Zero();
  for (const Push& push : pushes) sum += (push.vertices[0] >= 81 ? 1.0 : -1.0) * push.direction;
  return sum;
}

TEST(Untangling, PushesAreInBalance) {
  for (const double along : {0.0, 0.04}) {
    const test::Sheets sheets = makeCrossed(0.7, 0.02, along);
    const std::vector<Push> pushes = findPushes(sheets);
    ASSERT_GT(pushes.size(), 10u);
    for (const Push& push : pushes) {
      Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
      for (int v = 0; v < 5; ++v) {
        force += push.weight[v] * push.direction;
        torque += push.weight[v] * sheets.points[push.vertices[v]].cross(push.direction);
      }
      EXPECT_LT(force.norm(), 1e-12);
      EXPECT_LT(torque.norm(), 1e-12);
      EXPECT_LE(push.direction.norm(), 1.0 + 1e-12);
    }
  }
}

// The lighter part of the second sheet, below the first if the sheet is moved upwards and else above, is lighter than that of the
// first.
TEST(Untangling, TheLighterPartGoesBack) {
  for (const double angle : {0.1, 0.7, 1.5})
    for (const double side : {-1.0, 1.0}) {
      const std::vector<Push> pushes = findPushes(makeCrossed(angle, side * 0.02 * std::sin(angle)));
      ASSERT_GT(pushes.size(), 10u);
      const Vec3 sum = sumForces(pushes);
      EXPECT_GT(side * sum.z(), 0.7 * pushes.size()) << angle << ' ' << side;
    }
}

// Each sheet has an end of the line of crossings on its border, so that none is cut in two: they are drawn apart along the line.
TEST(Untangling, ALineThatCutsNothingOffIsShortened) {
  for (const double side : {-1.0, 1.0}) {
    const std::vector<Push> pushes = findPushes(makeCrossed(0.7, 0.0, side * 0.04));
    ASSERT_GT(pushes.size(), 5u);
    EXPECT_GT(side * sumForces(pushes).y(), 0.5) << side;
  }
}

TEST(Untangling, NothingIsPushedWhereNothingCrosses) { EXPECT_TRUE(findPushes(makeCrossed(0.1, 0.05)).empty()); }

// What is cut is not looked at.
TEST(Untangling, CutTrianglesDoNotCross) {
  const test::Sheets sheets = makeCrossed(0.7, 0.02);
  PairList pairs(sheets.points, sheets.triangles, 0.001);
  EXPECT_GT(pairs.numCrossed(), 0);
  std::vector<char> is_whole(sheets.triangles.size(), 1);
  for (std::size_t t = is_whole.size() / 2; t < is_whole.size(); ++t) is_whole[t] = 0;
  pairs.keepWhole(is_whole);
  EXPECT_TRUE(pairs.findCrossed(sheets.points));
  EXPECT_EQ(pairs.numCrossed(), 0);
}

}  // namespace
}  // namespace deformable_surface::contact
