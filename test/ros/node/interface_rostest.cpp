// The running node offers the topics and services of the table, with their types, and nothing else. All names are private. Two
// nodes run side by side.
#include "../../../src/ros/node/interface_page.h"
#include "../bad_clouds.h"
#include "../node_client.h"

#include <ros/master.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace deformable_surface::node::test {
namespace {

using Names = std::set<std::string>;

/// Part of the master's state: publishers 0, subscribers 1, services 2.
Names listNames(const std::string& node, int part) {
  XmlRpc::XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  EXPECT_TRUE(ros::master::execute("getSystemState", request, response, payload, true));
  Names names;
  for (int i = 0; i < payload[part].size(); ++i)
    for (int n = 0; n < payload[part][i][1].size(); ++n)
      if (std::string(payload[part][i][1][n]) == node) names.insert(payload[part][i][0]);
  return names;
}

/// Names that every program with roscpp, tf2 or dynamic loading of loggers has are left out.
Names leaveOutCommon(Names names, const std::string& node) {
  for (const std::string common : {std::string("/rosout"), std::string("/tf"), std::string("/tf_static"), std::string("/clock"),
                                   node + "/get_loggers", node + "/set_logger_level"})
    names.erase(common);
  return names;
}

Names listTable(const std::string& node, InterfaceKind kind) {
  Names names;
  for (const InterfaceEntry& entry : interfaceTable())
    if (entry.kind == kind) names.insert(entry.name[0] == '/' ? entry.name : node + "/" + entry.name);
  return names;
}

TEST(Interface, IsWhatTheTableSays) {
  NodeProcess process("/some_surface", "{model: mass_spring}");
  NodeClient client("/some_surface");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  const std::string node = "/some_surface";
  EXPECT_EQ(leaveOutCommon(listNames(node, 0), node), listTable(node, InterfaceKind::kPublished));
  EXPECT_EQ(leaveOutCommon(listNames(node, 1), node), listTable(node, InterfaceKind::kSubscribed));
  EXPECT_EQ(leaveOutCommon(listNames(node, 2), node), listTable(node, InterfaceKind::kService));
  ros::master::V_TopicInfo topics;
  ASSERT_TRUE(ros::master::getTopics(topics));
  for (const InterfaceEntry& entry : interfaceTable()) {
    if (entry.kind != InterfaceKind::kPublished) continue;
    const std::string name = entry.name[0] == '/' ? entry.name : node + "/" + entry.name;
    const auto found = std::find_if(topics.begin(), topics.end(), [&](const auto& topic) { return topic.name == name; });
    ASSERT_NE(found, topics.end()) << name;
    EXPECT_EQ(found->datatype, entry.type) << name;
  }
}

TEST(Interface, LetsSeveralSurfacesRunSideBySide) {
  NodeProcess left_process("/left", "{model: mass_spring, gravity: [0, 0, 0]}");
  NodeProcess right_process("/right", "{model: mass_spring, gravity: [0, 0, 0]}");
  NodeClient left("/left"), right("/right");
  ASSERT_TRUE(left.waitForNode() && right.waitForNode()) << left_process.output() << right_process.output();
  ASSERT_TRUE(left.pause(true).success && right.pause(true).success);
  PointCloud2 cloud = makeSheet(20, 10);
  cloud.header.stamp = ros::Time::now();
  ASSERT_TRUE(left.exchange(cloud));
  EXPECT_TRUE(right.frames.empty());
  ASSERT_TRUE(right.exchange(cloud));
  left.publish(makeForce("pull", Vec3(0.1, 0.05, 0.0), Vec3(0.0, 0.0, 0.01)));
  ASSERT_TRUE(left.waitForDiagnostic("commands waiting", 1));
  const StepResponse pulled = left.step(5), still = right.step(5);
  EXPECT_TRUE(pulled.success && still.success) << pulled.message << still.message;
  // A pull of 0.01 N over some millimetres, and rounding.
  EXPECT_GT(std::abs(pulled.energy), 1e-6);
  EXPECT_LT(std::abs(still.energy), 1e-15);
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "interface_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
