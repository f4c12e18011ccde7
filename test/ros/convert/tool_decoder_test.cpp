// Messages on ~tools from any sender: complete ones are read as roscpp reads them, broken ones are refused and get no memory.
#include "deformable_surface/ros/convert/tool_decoder.h"

#include "deformable_surface/ToolArray.h"

#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <cstring>

namespace deformable_surface::node {
namespace {

std::vector<std::uint8_t> serialize(const ToolArray& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

DecodedTools decode(const std::vector<std::uint8_t>& bytes) { return decodeTools(bytes.data(), bytes.size()); }

/// Two tools. Every field of the second one differs from its default.
ToolArray makeTools() {
  ToolArray message;
  message.tools.resize(2);
  Tool& tool = message.tools[1];
  tool.header.seq = 7;
  tool.header.stamp = ros::Time(3, 4);
  tool.header.frame_id = "hand";
  tool.id = "finger";
  tool.action = Tool::DELETE;
  tool.mode = Tool::CUT;
  tool.shape = Tool::PLANE;
  tool.primitive.type = shape_msgs::SolidPrimitive::BOX;
  tool.primitive.dimensions = {1.0, 2.0, 3.0};
  tool.plane.coef = {4.0, 5.0, 6.0, 7.0};
  tool.mesh.triangles.resize(2);
  tool.mesh.vertices.resize(3);
  tool.pose.position.y = 8.0;
  tool.pose.orientation.w = 1.0;
  tool.twist.linear.x = 9.0;
  tool.twist.angular.z = 10.0;
  tool.follow_frame = true;
  tool.friction = 0.5;
  tool.kinetic_friction = 0.25;
  tool.strength = 11.0;
  return message;
}

TEST(ToolDecoder, ReadsWhatRoscppWrites) {
  const ToolArray sent = makeTools();
  const DecodedTools decoded = decode(serialize(sent));
  ASSERT_TRUE(decoded.ok()) << decoded.problem;
  ToolArray received;
  received.tools = decoded.tools;
  EXPECT_EQ(serialize(received), serialize(sent));
}

TEST(ToolDecoder, RefusesAMessageThatEndsEarlyWhereverItDoes) {
  const std::vector<std::uint8_t> whole = serialize(makeTools());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const DecodedTools decoded = decodeTools(whole.data(), size);
    EXPECT_FALSE(decoded.ok()) << size;
    EXPECT_TRUE(decoded.tools.empty()) << size;
  }
}

TEST(ToolDecoder, SurvivesAnyLengthAnywhere) {
  const std::vector<std::uint8_t> whole = serialize(makeTools());
  for (const std::uint32_t claim : {0xffffffffu, 0x7fffffffu, 0x20000000u, 0x10000000u, 5000u})
    for (std::size_t at = 0; at + 4 <= whole.size(); ++at) {
      std::vector<std::uint8_t> bytes = whole;
      std::memcpy(bytes.data() + at, &claim, sizeof claim);
      const DecodedTools decoded = decode(bytes);
      // Numbers may have any value; lengths may not. No tool has more data than were sent.
      for (const Tool& tool : decoded.tools) EXPECT_LE(tool.primitive.dimensions.size(), 16u) << at;
      for (const Tool& tool : decoded.tools)
        EXPECT_LE(tool.mesh.triangles.size() + tool.mesh.vertices.size(), whole.size()) << at;
      EXPECT_TRUE(at != 0 || !decoded.ok());
    }
}

TEST(ToolDecoder, RefusesMoreToolsThanThereMayBe) {
  ToolArray message;
  message.tools.resize(kMaxTools);
  EXPECT_TRUE(decode(serialize(message)).ok());
  message.tools.resize(kMaxTools + 1);
  EXPECT_EQ(decode(serialize(message)).problem, "found 101 tools in a message; accepted: up to 100");
}

TEST(ToolDecoder, RefusesWhatComesBehindTheLastTool) {
  std::vector<std::uint8_t> bytes = serialize(makeTools());
  bytes.push_back(0);
  EXPECT_FALSE(decode(bytes).ok());
}

}  // namespace
}  // namespace deformable_surface::node
