// What is proven of a whole surface, checked on a part that moves while the others rest.
#include "deformable_surface/contact/part_clearance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "folded_sheets.h"

namespace deformable_surface::contact {
namespace {

constexpr int kSide = 9;

// The first rows of a sheet move, the others rest.
struct Moving {
  test::Sheets sheet = test::makeSheets(1, kSide, 0.0, 0.002);
  Points velocities = Points(sheet.points.size(), Vec3::Zero());
  std::vector<Index> part;
  Clearance clearance{sheet.points, sheet.triangles, 0.001};

  Moving() {
    for (Index i = 0; i < 3 * kSide; ++i) {
      part.push_back(i);
      velocities[i] = i < 2 * kSide ? Vec3(0.0, 0.0, 0.01 * (2 * kSide - i)) : Vec3::Zero();
    }
  }
  Points partOf(const Points& positions) const { return {positions.begin(), positions.begin() + part.size()}; }
  Points at(double time) const {
    Points positions = sheet.points;
    for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += time * velocities[i];
    return positions;
  }
};

TEST(PartClearance, CoversWhatIsPredictedAndNothingElse) {
  Moving moving;
  ASSERT_TRUE(moving.clearance.prove(moving.sheet.points, moving.velocities, 0.1));
  const double tolerance = moving.clearance.proven()->tolerance;
  PartClearance part(moving.part, static_cast<Index>(moving.sheet.points.size()));
  ASSERT_TRUE(part.follow(moving.clearance.proven(), moving.sheet.points));
  for (const double time : {0.0, 0.03, 0.1}) {
    Points now = moving.partOf(moving.at(time));
    EXPECT_TRUE(part.covers(now)) << time;
    now[20].x() += 0.9 * tolerance;
    EXPECT_TRUE(part.covers(now)) << time;
    now[20].x() += 0.2 * tolerance;
    EXPECT_FALSE(part.covers(now)) << time;
    now[20].x() = std::nan("");
    EXPECT_FALSE(part.covers(now)) << time;
  }
}

TEST(PartClearance, FollowsOnlyAProofInWhichTheOthersRest) {
  Moving moving;
  const Index n = static_cast<Index>(moving.sheet.points.size());
  PartClearance part(moving.part, n);
  EXPECT_FALSE(part.follow(nullptr, moving.sheet.points));
  ASSERT_TRUE(moving.clearance.prove(moving.sheet.points, moving.velocities, 0.1));
  Points elsewhere = moving.sheet.points;
  elsewhere[n - 1].z() += 2.0 * moving.clearance.proven()->tolerance;
  EXPECT_FALSE(part.follow(moving.clearance.proven(), elsewhere));
  elsewhere = moving.sheet.points;
  elsewhere[0].z() += 1.0;  // of the part: not read
  EXPECT_TRUE(part.follow(moving.clearance.proven(), elsewhere));
  moving.velocities[n - 1] = Vec3(0.0, 0.0, 1e-3);
  ASSERT_TRUE(moving.clearance.prove(moving.sheet.points, moving.velocities, 0.1));
  EXPECT_FALSE(part.follow(moving.clearance.proven(), moving.sheet.points));
}

// A part whose fastest point lies elsewhere in the whole than in the part, and a part that rests.
TEST(PartClearance, KnowsTheLeaderByItsPlaceInThePart) {
  Moving moving;
  const Index n = static_cast<Index>(moving.sheet.points.size());
  std::vector<Index> last;
  Points velocities(n, Vec3::Zero());
  for (Index i = n - 2 * kSide; i < n; ++i) last.push_back(i);
  velocities[n - 1] = Vec3(0.0, 0.0, 0.1);
  ASSERT_TRUE(moving.clearance.prove(moving.sheet.points, velocities, 0.1));
  PartClearance part(last, n);
  ASSERT_TRUE(part.follow(moving.clearance.proven(), moving.sheet.points));
  Points now(moving.sheet.points.end() - 2 * kSide, moving.sheet.points.end());
  EXPECT_TRUE(part.covers(now));
  now.back().z() += 0.005;
  EXPECT_TRUE(part.covers(now));
  ASSERT_TRUE(moving.clearance.prove(moving.sheet.points, Points(n, Vec3::Zero()), 0.1));
  ASSERT_TRUE(part.follow(moving.clearance.proven(), moving.sheet.points));
  now = Points(moving.sheet.points.end() - 2 * kSide, moving.sheet.points.end());
  EXPECT_TRUE(part.covers(now));
}

}  // namespace
}  // namespace deformable_surface::contact
