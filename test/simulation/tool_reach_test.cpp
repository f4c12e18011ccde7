// The bounding ball of a tool, and the points within its reach.
#include "../../src/simulation/tool_reach.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::simulation {
namespace {

TEST(ToolReach, IsTheRadiusOfTheBallAboutTheOriginThatHoldsTheShape) {
  geometry::Solid shape;
  shape.kind = geometry::Solid::Kind::kSphere;
  shape.radius = 0.2;
  EXPECT_DOUBLE_EQ(findRadius(shape), 0.2);
  shape.kind = geometry::Solid::Kind::kBox;
  shape.size = Vec3(0.6, 0.8, 2.4);
  EXPECT_DOUBLE_EQ(findRadius(shape), 1.3);
  shape.kind = geometry::Solid::Kind::kPlane;
  EXPECT_TRUE(std::isinf(findRadius(shape)));
}

TEST(ToolReach, EndsWhereTheToolDoesAndWhileItDoesNotAct) {
  tool::ToolParams ball;
  ball.shape.kind = geometry::Solid::Kind::kSphere;
  ball.shape.radius = 0.1;
  ball.start = 1.0;
  ball.path = {{0.0, Vec3(1.0, 0.0, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)}};
  EXPECT_TRUE(isInReach(ball, 1.5, {Vec3::Zero(), Vec3(1.05, 0.0, 0.0)}));
  EXPECT_FALSE(isInReach(ball, 1.5, {Vec3::Zero(), Vec3(1.11, 0.0, 0.0)}));
  EXPECT_FALSE(isInReach(ball, 0.5, {Vec3(1.05, 0.0, 0.0)}));
  ball.mode = tool::Mode::kAttract;
  ball.reach = 0.5;
  EXPECT_TRUE(isInReach(ball, 1.5, {Vec3(1.55, 0.0, 0.0)}));
  EXPECT_FALSE(isInReach(ball, 1.5, {Vec3(1.65, 0.0, 0.0)}));
}

}  // namespace
}  // namespace deformable_surface::simulation
