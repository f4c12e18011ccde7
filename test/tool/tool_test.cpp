#include "deformable_surface/tool/tool.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using tool::interpolate;

TEST(Tool, MovesStraightAndTurnsEvenlyBetweenWaypointsAndRestsOutside) {
  const double half = std::sqrt(0.5);
  const std::vector<tool::WaypointParams> path{{1.0, Vec3(0.0, 0.0, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)},
                                               {3.0, Vec3(2.0, 0.0, 4.0), Vec4(0.0, 0.0, half, half)}};
  EXPECT_EQ(interpolate(path, 0.0).position, Vec3::Zero());
  EXPECT_EQ(interpolate(path, 9.0).position, Vec3(2.0, 0.0, 4.0));
  EXPECT_TRUE(interpolate(path, 2.0).position.isApprox(Vec3(1.0, 0.0, 2.0), 1e-15));
  EXPECT_TRUE(tool::findMotion(path, 1.5).velocity.isApprox(Vec3(1.0, 0.0, 2.0), 1e-15));
  EXPECT_TRUE(tool::findMotion(path, 1.5).angular_velocity.isApprox(Vec3(0.0, 0.0, 0.25 * M_PI), 1e-12));
  EXPECT_TRUE(tool::findMotion(path, 3.0).velocity.isZero(0.0));
  const Vec3 x = interpolate(path, 1.5).orientation * Vec3::UnitX();
  EXPECT_NEAR(std::atan2(x.y(), x.x()), M_PI / 8.0, 1e-12);
}

TEST(Tool, CornersOfAPathLieStrictlyBetweenTwoTimes) {
  std::vector<tool::WaypointParams> path;
  for (const double time : {0.0, 1.0, 1.5, 2.0}) path.push_back({time, Vec3::Zero()});
  std::vector<double> corners;
  tool::forEachCorner(path, 0.0, 2.0, [&](double time) { corners.push_back(time); });
  EXPECT_EQ(corners, (std::vector<double>{1.0, 1.5}));
}

TEST(Tool, DistancesFollowThePose) {
  geometry::Solid box;
  box.kind = geometry::Solid::Kind::kBox;
  box.size = Vec3(2.0, 0.2, 0.2);
  const tool::Pose pose{Vec3(0.0, 0.0, 1.0), Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitY()))};
  const geometry::SignedDistance d = tool::findSignedDistance(box, pose, Vec3(0.0, 0.0, 2.5));
  EXPECT_NEAR(d.distance, 0.5, 1e-12);
  EXPECT_TRUE(d.normal.isApprox(Vec3::UnitZ(), 1e-12));
}

TEST(ToolParams, RefuseWhatIsNotATool) {
  const auto problems = [](const tool::ToolParams& p) { return checkParams(p); };
  tool::ToolParams good;
  good.id = "ball";
  good.path = {{}};
  EXPECT_TRUE(problems(good).empty());
  tool::ToolParams bad = good;
  bad.path.clear();
  EXPECT_EQ(problems(bad).size(), 1u);
  bad = good;
  bad.path.push_back({});
  EXPECT_EQ(problems(bad).size(), 1u);
  bad = good;
  bad.path[0].orientation = Vec4(0.0, 0.0, 0.0, 0.9);
  EXPECT_EQ(problems(bad).size(), 1u);
  bad = good;
  bad.friction = -0.3;
  EXPECT_EQ(problems(bad).size(), 1u);
  bad = good;
  bad.start = bad.end = 1.0;
  EXPECT_EQ(problems(bad).size(), 1u);
  bad = good;
  bad.mode = tool::Mode::kAttract;  // without strength and reach
  EXPECT_EQ(problems(bad).size(), 2u);
  bad = good;
  bad.shape.radius = 0.0;
  EXPECT_EQ(problems(bad).size(), 1u);
}

}  // namespace
}  // namespace deformable_surface::test
