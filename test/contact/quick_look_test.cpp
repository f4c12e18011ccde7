// A quick look sees parts that come near each other, and none in shapes that only bend.
#include "deformable_surface/contact/quick_look.h"

#include "deformable_surface/contact/crossings.h"
#include "deformable_surface/contact/pair_list.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "folded_sheets.h"

namespace deformable_surface::contact {
namespace {

// A look at a surface of its own.
class Looker {
 public:
  Looker(const test::Sheets& sheets, double reach, bool is_body = false)
      : list_(sheets.points, sheets.triangles, 1e-4),
        look_(sheets.points, sheets.triangles, list_.edges(), list_.patches(), reach, is_body) {}

  bool isAnyNear(const Points& positions) { return look_.isAnyNear(positions); }
  const Vec3& placeSeen() const { return look_.placeSeen(); }
  double edge() const { return list_.medianEdge(); }

 private:
  PairList list_;
  QuickLook look_;
};

TEST(QuickLook, SeesNothingNearInShapesAtRest) {
  for (const double jitter : {0.0, 0.001, 0.0015}) {
    const test::Sheets sheet = test::makeSheets(1, 20, 0.0, jitter);
    EXPECT_FALSE(Looker(sheet, 0.004).isAnyNear(sheet.points)) << jitter;
  }
  const test::Sheets ball = test::makeBall(11, 20);
  EXPECT_FALSE(Looker(ball, 0.006).isAnyNear(ball.points));
}

// Rows seven times as dense as wide: points four of the short edges apart are within reach for the long ones.
TEST(QuickLook, SeesNothingNearInUnevenTriangles) {
  test::Sheets sheet = test::makeSheets(1, 14, 0.0, 0.0);
  for (Vec3& x : sheet.points) x.x() /= 7.0;
  EXPECT_FALSE(Looker(sheet, 0.002).isAnyNear(sheet.points));
}

// Two flat bodies, each thinner than the reach, one above the other.
TEST(QuickLook, SeesRoomBetweenBodiesAndNotTheirOwnThickness) {
  test::Sheets bodies = test::makeBall(11, 20);
  for (Vec3& x : bodies.points) x.z() *= 0.15;
  EXPECT_TRUE(Looker(bodies, 0.006).isAnyNear(bodies.points));
  EXPECT_FALSE(Looker(bodies, 0.006, true).isAnyNear(bodies.points));
  const Index n = static_cast<Index>(bodies.points.size());
  const std::vector<Triangle> one = bodies.triangles;
  for (const Triangle& t : one) bodies.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  for (Index i = 0; i < n; ++i) bodies.points.push_back(bodies.points[i] + Vec3(0.0, 0.0, 0.025));
  Looker looker(bodies, 0.006, true);
  EXPECT_TRUE(looker.isAnyNear(bodies.points));
  EXPECT_NEAR(looker.placeSeen().z(), 0.0125, 0.002);
  Points apart = bodies.points;
  for (Index i = n; i < 2 * n; ++i) apart[i].z() += 0.02;
  EXPECT_FALSE(looker.isAnyNear(apart));
  // Whichever way round their corners go.
  for (Triangle& t : bodies.triangles) std::swap(t[1], t[2]);
  EXPECT_FALSE(Looker(bodies, 0.006, true).isAnyNear(apart));
}

TEST(QuickLook, SeesNothingNearInABallThatStretchesTurnsAndBends) {
  const test::Sheets ball = test::makeBall(11, 20);
  Looker looker(ball, 0.006);
  Points positions = ball.points;
  const Eigen::AngleAxisd turn(1.0, Vec3(1.0, 2.0, 3.0).normalized());
  for (Vec3& x : positions) x = turn * Vec3(1.4 * x.x(), x.y() + 5.0 * x.x() * x.x(), 0.8 * x.z()) + Vec3(3.0, 0.0, 1.0);
  EXPECT_FALSE(looker.isAnyNear(positions));
}

// Two layers that come together, staggered or not, are seen before they are nearer than the reach.
TEST(QuickLook, SeesLayersBeforeTheyMeet) {
  std::mt19937 generator(5);
  for (const double gap : {0.0301, 0.02}) {
    const test::Sheets sheets = test::makeSheets(2, 14, gap, 0.0005);
    const Index half = static_cast<Index>(sheets.points.size()) / 2;
    for (int k = 0; k < 20; ++k) {
      const double reach = 0.003;
      Looker looker(sheets, reach);
      Points positions = sheets.points;
      const Vec3 aside = 0.004 * test::randomVector(generator);
      for (Index i = half; i < 2 * half; ++i) positions[i] += Vec3(aside.x(), aside.y(), reach - gap);
      EXPECT_TRUE(looker.isAnyNear(positions));
      for (Index i = half; i < 2 * half; ++i) positions[i].z() += 3.0 * looker.edge();
      EXPECT_FALSE(looker.isAnyNear(positions));
    }
  }
}

// Also points that one patch holds: it divides space, not the surface.
TEST(QuickLook, SeesTwoLayersWithinAPatch) {
  const test::Sheets sheets = test::makeSheets(2, 4, 0.001, 0.0);
  Looker looker(sheets, 0.002);
  EXPECT_TRUE(looker.isAnyNear(sheets.points));
}

// About the points of a column, by an angle.
Points fold(const Points& sheet, double angle) {
  const double column = 0.1 * 7 / 13;
  Points folded = sheet;
  for (Vec3& x : folded)
    if (x.x() > column) x = Vec3(column, x.y(), 0.0) + (x.x() - column) * Vec3(std::cos(angle), 0.0, std::sin(angle));
  return folded;
}

TEST(QuickLook, SeesSharpFolds) {
  const test::Sheets sheet = test::makeSheets(1, 14, 0.0, 0.0);
  Looker looker(sheet, 0.001);
  EXPECT_FALSE(looker.isAnyNear(fold(sheet.points, 1.4)));
  EXPECT_TRUE(looker.isAnyNear(fold(sheet.points, 1.8)));
}

// Corners that are sharp at rest do not count until they are sharper.
TEST(QuickLook, LeavesOutFoldsThatAreSharpAtRest) {
  test::Sheets corner = test::makeSheets(1, 14, 0.0, 0.0);
  const Points at_rest = fold(corner.points, 1.8), sharper = fold(corner.points, 2.4);
  corner.points = at_rest;
  Looker looker(corner, 0.001);
  EXPECT_FALSE(looker.isAnyNear(at_rest));
  EXPECT_TRUE(looker.isAnyNear(sharper));
}

// Bent by less than a right angle at each column, until the sides come near.
TEST(QuickLook, SeesASheetThatRollsUp) {
  const test::Sheets sheet = test::makeSheets(1, 14, 0.0, 0.0);
  Looker looker(sheet, 0.001);
  const auto roll = [&](double radius) {
    Points rolled = sheet.points;
    for (Vec3& x : rolled) x = Vec3(radius * std::sin(x.x() / radius), x.y(), radius - radius * std::cos(x.x() / radius));
    return rolled;
  };
  EXPECT_FALSE(looker.isAnyNear(roll(0.03)));
  EXPECT_TRUE(looker.isAnyNear(roll(0.014)));
}

// A shell as thick as its edges are long: what is farther along it than its thickness counts.
TEST(QuickLook, SeesNothingNearInAThickShell) {
  const test::Sheets ball = test::makeBall(11, 20);
  const double edge = Looker(ball, 0.001).edge();
  EXPECT_FALSE(Looker(ball, 2.2 * edge).isAnyNear(ball.points));
  EXPECT_TRUE(Looker(ball, 20.0 * edge).isAnyNear(ball.points));
}

// The order of corners may differ from triangle to triangle.
TEST(QuickLook, DoesNotNeedTrianglesOfOneOrientation) {
  test::Sheets sheet = test::makeSheets(1, 14, 0.0, 0.0005);
  for (std::size_t t = 0; t < sheet.triangles.size(); t += 3) std::swap(sheet.triangles[t][1], sheet.triangles[t][2]);
  EXPECT_FALSE(Looker(sheet, 0.001).isAnyNear(sheet.points));
}

TEST(QuickLook, TakesUndefinedNumbersForNear) {
  const test::Sheets ball = test::makeBall(11, 20);
  Looker looker(ball, 0.006);
  Points positions = ball.points;
  positions[7].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(looker.isAnyNear(positions));
}

}  // namespace
}  // namespace deformable_surface::contact
