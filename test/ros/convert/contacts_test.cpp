// Single contacts, as a message.
#include "deformable_surface/ros/convert/contacts.h"

#include <gtest/gtest.h>

namespace deformable_surface::node {
namespace {

TEST(Contacts, NameTheToolOrBothPartsOfTheSurface) {
  tool::ToolParams idle, ball;
  idle.id = "idle";
  ball.id = "ball";
  const simulation::Contact touch{1, 17, Vec3(1, 2, 3), Vec3(0, 0, 1), 0.001, Vec3(0, 1, 2)};
  const simulation::SelfTouch fold{{4, 5, 6, 7}, {1.0, -0.2, -0.3, -0.5}, Vec3(4, 5, 6), Vec3(1, 0, 0), 0.002, Vec3(3, 0, 0)};
  std_msgs::Header header;
  header.frame_id = "table";
  const ContactArray message = makeContacts(header, {idle, ball}, {touch}, {fold});
  EXPECT_EQ(message.header.frame_id, "table");
  ASSERT_EQ(message.contacts.size(), 2u);
  EXPECT_EQ(message.contacts[0].tool, "ball");
  EXPECT_EQ(message.contacts[0].points, std::vector<std::uint32_t>{17});
  EXPECT_EQ(message.contacts[0].weights, std::vector<double>{1.0});
  EXPECT_EQ(message.contacts[0].position.z, 3.0);
  EXPECT_EQ(message.contacts[0].normal.z, 1.0);
  EXPECT_EQ(message.contacts[0].depth, 0.001);
  EXPECT_EQ(message.contacts[0].force.y, 1.0);
  EXPECT_EQ(message.contacts[1].tool, "");
  EXPECT_EQ(message.contacts[1].points, (std::vector<std::uint32_t>{4, 5, 6, 7}));
  EXPECT_EQ(message.contacts[1].weights, (std::vector<double>{1.0, -0.2, -0.3, -0.5}));
  EXPECT_EQ(message.contacts[1].depth, 0.002);
  EXPECT_EQ(message.contacts[1].force.x, 3.0);
}

}  // namespace
}  // namespace deformable_surface::node
