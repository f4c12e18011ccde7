// Wrenches of the surface on tools and pins, as messages.
#include "deformable_surface/ros/convert/tool_wrenches.h"

#include <gtest/gtest.h>

namespace deformable_surface::node {
namespace {

TEST(ToolWrenches, HaveToolsAndPinsWithEverythingThatIsKnownOfThem) {
  simulation::ToolReaction tool;
  tool.id = "ball";
  tool.force = Vec3(1, 2, 3);
  tool.torque = Vec3(4, 5, 6);
  tool.contacts = 7;
  tool.penetration = 8.0;
  simulation::PinReaction pin;
  pin.id = "pins[0]";
  pin.force = Vec3(-1, -2, -3);
  pin.torque = Vec3(-4, -5, -6);
  pin.points = 9;
  std_msgs::Header header;
  header.frame_id = "table";
  const ToolWrenchArray message = makeToolWrenches(header, {tool}, {pin}, {"other"});
  EXPECT_EQ(message.header.frame_id, "table");
  ASSERT_EQ(message.wrenches.size(), 1u);
  EXPECT_EQ(message.wrenches[0].id, "ball");
  EXPECT_EQ(message.wrenches[0].wrench.force.y, 2.0);
  EXPECT_EQ(message.wrenches[0].wrench.torque.z, 6.0);
  EXPECT_EQ(message.wrenches[0].contacts, 7u);
  EXPECT_EQ(message.wrenches[0].penetration, 8.0);
  EXPECT_FALSE(message.wrenches[0].silent);
  const ToolWrench silent = makeToolWrenches(header, {tool}, {pin}, {"ball"}).wrenches[0];
  EXPECT_TRUE(silent.silent);
  EXPECT_TRUE(silent.stale);  // its old name
  ASSERT_EQ(message.pins.size(), 1u);
  EXPECT_EQ(message.pins[0].id, "pins[0]");
  EXPECT_EQ(message.pins[0].wrench.force.x, -1.0);
  EXPECT_EQ(message.pins[0].wrench.torque.y, -5.0);
  EXPECT_EQ(message.pins[0].points, 9u);
}

}  // namespace
}  // namespace deformable_surface::node
