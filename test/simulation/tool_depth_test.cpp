// What contact with tools leaves, in the error estimate. In these scenes only simulation points touch tools, unless said
// otherwise.
#include "../../src/simulation/tool_depth.h"

#include "clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using simulation::ToolDepth;

SceneParams scene() {
  SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.contact.cloud_points = 0;
  return p;
}

tool::ToolParams ball(double radius, const Vec3& from, const Vec3& to) {
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.kind = geometry::Solid::Kind::kSphere;
  ball.shape.radius = radius;
  ball.path.resize(2);
  ball.path[0].position = from;
  ball.path[1].position = to;
  ball.path[1].time = 0.1;
  return ball;
}

// A place far from all simulation points.
Vec3 findGap(const SceneParams& p) {
  const Simulation s(p, sheetCloud());
  Vec3 place = Vec3::Zero();
  double largest = 0.0;
  for (const model::WeightedTriangle& t : trianglesOf(s.model())) {
    const Points& x = s.state().positions;
    const Vec3 middle = (x[t.corner[0]] + x[t.corner[1]] + x[t.corner[2]]) / 3.0;
    if ((middle - Vec3(0.5, 0.5, 0.0)).norm() > 0.3) continue;
    double nearest = 1.0;
    for (const Vec3& other : x) nearest = std::min(nearest, (other - middle).norm());
    if (nearest <= largest) continue;
    largest = nearest;
    place = middle;
  }
  return place;
}

// A ball that comes from above to a place: as far as a share of its radius below it.
SceneParams pressed(double radius, double share) {
  SceneParams p = scene();
  const Vec3 place = findGap(p);
  p.tools.push_back(ball(radius, place + 1.01 * radius * Vec3::UnitZ(), place + (1.0 - share) * radius * Vec3::UnitZ()));
  return p;
}

// m, of the published points, at a time.
double findDeepest(Simulation& s) {
  const tool::ToolParams& tool = s.tools().front();
  const tool::Pose pose = tool::interpolate(tool.path, s.time());
  double deepest = 0.0;
  for (const Vec3& x : s.surface(false).positions)
    deepest = std::max(deepest, -tool::findSignedDistance(tool.shape, pose, x).distance);
  return deepest;
}

std::string runTold(Simulation& s, int steps) {
  std::string notices;
  for (int k = 0; k < steps; ++k) notices += s.step().notice;
  return notices;
}

TEST(ToolDepth, IsThatOfTheDeepestPointOfTheCloud) {
  Simulation s(pressed(0.08, 0.5), sheetCloud());
  ToolDepth depth(s.dynamics());
  EXPECT_EQ(depth.measure(s.dynamics()), 0.0);
  run(s, 10);
  const double deepest = findDeepest(s);
  EXPECT_GT(deepest, 0.005);
  EXPECT_NEAR(depth.measure(s.dynamics()), deepest, 1e-6);
  EXPECT_EQ(ToolDepth(depth).measure(s.dynamics()), depth.measure(s.dynamics()));
}

TEST(ToolDepth, IsNotThatOfPinnedPoints) {
  SceneParams p = scene();
  p.pins.front().region.max.x() = 1.0;  // all of it
  p.tools.push_back(ball(0.1, Vec3(0.5, 0.5, 0.2), Vec3(0.5, 0.5, 0.05)));
  p.accuracy.estimate = true;
  Simulation s(p, sheetCloud());
  EXPECT_EQ(runTold(s, 12).find("no bound"), std::string::npos);
  EXPECT_GT(findDeepest(s), 0.04);
  EXPECT_EQ(ToolDepth(s.dynamics()).measure(s.dynamics()), 0.0);
}

TEST(ErrorEstimateOfTools, IsNoLessThanTheDepthOfPointsInThem) {
  Simulation s(pressed(0.08, 0.5), sheetCloud());
  for (int k = 0; k < 12; ++k) {
    run(s, 1);
    EXPECT_GE(s.statistics().error_estimate, findDeepest(s)) << k;
  }
}

TEST(ErrorEstimateOfTools, IsNoBoundOnceOneIsBetweenThePointsThatTouchAndSaysSo) {
  SceneParams p = pressed(0.045, 1.0);
  Simulation s(p, sheetCloud());
  EXPECT_NE(runTold(s, 12).find("tool 'ball' is in the surface"), std::string::npos);
  EXPECT_FALSE(s.statistics().error_bounded);
  s.reset();
  EXPECT_TRUE(s.statistics().error_bounded);

  p.contact.cloud_points = 8;
  p.tools.front().shape.radius = 0.06;
  Simulation felt(p, sheetCloud());
  EXPECT_EQ(runTold(felt, 12).find("is in the surface"), std::string::npos);
}

// In the surface or on a point of it.
TEST(ErrorEstimateOfTools, IsNoBoundOnceANeedleTouchesAndSaysSo) {
  for (const Index cloud_points : {0, 8}) {
    SceneParams p = pressed(0.02, 1.0);  // a quarter of the spacing of the simulation points in radius
    p.contact.cloud_points = cloud_points;
    Simulation s(p, sheetCloud());
    EXPECT_TRUE(s.statistics().error_bounded);
    EXPECT_NE(runTold(s, 12).find("no bound until the next reset: tool 'ball' is narrower than one and a half spacings"),
              std::string::npos);
    EXPECT_FALSE(s.statistics().error_bounded);
  }
}

// Within a step, so that it is in the surface at no end of one; also from a snapshot, whose steps are told no more.
TEST(ErrorEstimateOfTools, IsNoBoundOnceOneHasGoneThrough) {
  SceneParams p = pressed(0.045, 1.0);
  auto& path = p.tools.front().path;
  path[0].position.z() = 0.5;
  path[1].position.z() = -9.5;
  Simulation s(p, sheetCloud());
  EXPECT_TRUE(s.statistics().error_bounded);
  const simulation::Snapshot before = s.snapshot();
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(runTold(s, 12).find("tool 'ball' is in"), std::string::npos);
    EXPECT_FALSE(s.statistics().error_bounded);
    s.restore(before);
    EXPECT_TRUE(s.statistics().error_bounded);
  }
}

TEST(ErrorEstimateOfTools, GoesOnBitForBitInForksAndFromSnapshots) {
  Simulation s(pressed(0.08, 0.5), sheetCloud());
  run(s, 8);
  const simulation::Snapshot snapshot = s.snapshot();
  Simulation fork = s.fork();
  run(s, 4);
  run(fork, 4);
  const double estimate = s.statistics().error_estimate;
  EXPECT_EQ(fork.statistics().error_estimate, estimate);
  s.restore(snapshot);
  run(s, 4);
  EXPECT_EQ(s.statistics().error_estimate, estimate);
}

}  // namespace
}  // namespace deformable_surface::test
