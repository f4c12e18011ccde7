// A knife in a step: the links found between its faces are those that a check of all links finds, and the number of checks.
#include "deformable_surface/tool/blade.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace deformable_surface::tool {
namespace {

constexpr double kStep = 0.02;  // s

ToolParams makeKnife(const Vec3& size, std::vector<WaypointParams> path) {
  ToolParams tool;
  tool.id = "knife";
  tool.mode = Mode::kCut;
  tool.shape.kind = geometry::Solid::Kind::kBox;
  tool.shape.size = size;
  tool.path = std::move(path);
  return tool;
}

Vec3 toTool(const Pose& pose, const Vec3& point) { return pose.orientation.conjugate() * (point - pose.position); }

// At every sampled time.
bool wentBetweenAtAll(const ToolParams& tool, BladeSweep::Look looks, const Vec3& a, const Vec3& a_after, const Vec3& b,
                      const Vec3& b_after) {
  for (BladeSweep::Look k = 0; k <= looks; ++k) {
    const Pose pose = interpolate(tool.path, static_cast<double>(k) * kStep / static_cast<double>(looks));
    const double share = static_cast<double>(k) / static_cast<double>(looks);
    if (isBetween(tool.shape, toTool(pose, a + share * (a_after - a)), toTool(pose, b + share * (b_after - b)))) return true;
  }
  return false;
}

TEST(BladeSweep, FindsACutWithWorkThatDoesNotGrowWithTheJump) {
  const Points points = {Vec3(0.0, -0.01, 0.0), Vec3(0.0, 0.01, 0.0)};
  std::int64_t most = 0;
  for (const double jump : {1.0, 1e2, 1e4, 1e6}) {
    // Flat across its path: it must be sampled while it is between the two points, which lasts only a short time.
    const ToolParams tool =
        makeKnife(Vec3(0.3, 0.001, 0.3), {{0.0, Vec3(-0.4 * jump, 0.002, 0.0)}, {kStep, Vec3(0.6 * jump, 0.002, 0.0)}});
    const BladeSweep blade(tool, 0.0, kStep, points, points, 0.02, 0.0005);
    std::int64_t taken = 0;
    EXPECT_TRUE(blade.wentBetween(points[0], points[0], points[1], points[1], blade.all(), &taken)) << jump;
    most = std::max(most, taken);
    // One that it passes by at ten centimetres.
    const Vec3 aside(0.0, 0.0, 0.26), beside(0.0, 0.02, 0.26);
    EXPECT_FALSE(blade.wentBetween(aside, aside, beside, beside, blade.all(), &taken)) << jump;
    most = std::max(most, taken);
  }
  EXPECT_LT(most, 200);
}

TEST(BladeSweep, DoesNotLookForEverWhereAToolWaitsBeforeItJumps) {
  const Points points = {Vec3(-0.01, 0.0, 0.0), Vec3(0.01, 0.0, 0.0)};
  const ToolParams tool =
      makeKnife(Vec3(0.001, 0.3, 0.3),
                {{0.0, Vec3(0.0095, 0.151, 0.0)}, {0.9 * kStep, Vec3(0.0095, 0.151, 0.0)}, {kStep, Vec3(0.0095, 1000.0, 0.0)}});
  const BladeSweep blade(tool, 0.0, kStep, points, points, 0.05, 0.0005);
  std::int64_t taken = 0;
  EXPECT_FALSE(blade.wentBetween(points[0], points[0], points[1], points[1], blade.all(), &taken));
  EXPECT_LT(taken, 1000);
}

TEST(BladeSweep, FindsWhatAllLooksTogetherFind) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  const auto draw = [&](double size) { return Vec3(size * Vec3(number(generator), number(generator), number(generator))); };
  int went = 0, stayed = 0;
  for (int scene = 0; scene < 150; ++scene) {
    const double spacing = 0.1;
    std::vector<WaypointParams> path;
    for (int w = 0; w <= scene % 4 + 1; ++w) {
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(3.0 * number(generator), draw(1.0).normalized()));
      path.push_back({kStep * (w == 0 ? 0.0 : w + 0.4 * number(generator)) / (scene % 4 + 1), draw(scene % 3 == 0 ? 5.0 : 0.4),
                      Vec4(turn.x(), turn.y(), turn.z(), turn.w())});
    }
    ToolParams tool = makeKnife(Vec3(0.02, 0.5, 0.3), path);
    if (scene % 5 == 0) tool.shape.kind = geometry::Solid::Kind::kCone;
    tool.shape.radius = 0.05;
    tool.shape.height = 0.6;
    Points before, after;
    for (int k = 0; k < 12; ++k) {
      before.push_back(draw(0.3));
      before.push_back(before.back() + draw(0.5 * spacing));
      const Vec3 motion = draw(scene % 2 == 0 ? 0.0 : 0.3);
      after.push_back(before[2 * k] + motion);
      after.push_back(before[2 * k + 1] + motion + draw(0.1 * spacing));
    }
    const BladeSweep blade(tool, 0.0, kStep, before, after, spacing, 0.02);
    for (std::size_t i = 0; blade.isNear() && i < before.size(); i += 2) {
      const bool expected = wentBetweenAtAll(tool, blade.all().last, before[i], after[i], before[i + 1], after[i + 1]);
      const bool found = blade.wentBetween(before[i], after[i], before[i + 1], after[i + 1], blade.all());
      EXPECT_EQ(found, expected);
      ++(expected ? went : stayed);
      // The sampled times that are found for a ball around both points are sufficient.
      const BladeSweep::Looks looks = blade.findLooks(before[i], after[i], 1.05 * spacing);
      EXPECT_EQ(blade.wentBetween(before[i], after[i], before[i + 1], after[i + 1], looks), found);
    }
  }
  EXPECT_GT(went, 50);
  EXPECT_GT(stayed, 300);
}

TEST(BladeSweep, APlaneHasNoOtherSideAndGoesBetweenNothing) {
  const Points points = {Vec3(0.0, 0.0, -0.01), Vec3(0.0, 0.0, 0.01)};
  ToolParams tool = makeKnife(Vec3::Ones(), {{0.0, Vec3(-1.0, 0.0, 0.0)}, {0.1, Vec3(1000.0, 0.0, 0.0)}});
  tool.shape.kind = geometry::Solid::Kind::kPlane;
  tool.shape.normal = Vec3::UnitZ();
  const BladeSweep blade(tool, 0.0, kStep, points, points, 0.02, 0.0005);
  EXPECT_FALSE(blade.isNear());
}

}  // namespace
}  // namespace deformable_surface::tool
