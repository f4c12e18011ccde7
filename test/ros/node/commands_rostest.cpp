// Commands of a client in any frame: forces, wrenches, tools, pins; refused commands, and their messages.
#include "surface_node_fixture.h"

#include "deformable_surface/ContactArray.h"
#include "deformable_surface/ToolArray.h"
#include "deformable_surface/ToolStatusArray.h"
#include "deformable_surface/ToolWrenchArray.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::node::test {
namespace {

using CommandsTest = SurfaceNodeTest;

const char* const kTurnedGravity =
    "{model: mass_spring, gravity: [0, 0, -1], gravity_frame: world, output: {publish_rate: 100.0, stamp: simulation}}";

TEST_F(CommandsTest, PinsAndFreesWhatLiesInAShape) {
  ASSERT_TRUE(startPaused());
  SelectRegionRequest far_end;
  far_end.primitive.type = shape_msgs::SolidPrimitive::BOX;
  far_end.primitive.dimensions = {0.1, 1.0, 1.0};
  far_end.pose.position.x = kSpacing * (kColumns - 1);
  const SelectRegionResponse pinned = client_->select("pin", far_end);
  EXPECT_TRUE(pinned.success) << pinned.message;
  EXPECT_GT(pinned.count, 0u);
  const int end = 7 * kColumns + kColumns - 2;
  const auto pull = [&] {
    client_->publish(makeForce("pull", Vec3(kSpacing * (kColumns - 1), 0.1, 0.0), Vec3(0.0, 0.0, 0.02), 0.05));
    EXPECT_TRUE(client_->waitForDiagnostic("commands waiting", 1));
  };
  pull();
  ASSERT_TRUE(client_->step(20).success);
  auto frame = client_->waitForFrame(stampAfter(20));
  ASSERT_TRUE(frame);
  EXPECT_LT(std::abs(readField(*frame, end, "z")), 1e-6);

  EXPECT_EQ(client_->select("unpin", far_end).count, pinned.count);
  ASSERT_TRUE(client_->step(20).success);
  frame = client_->waitForFrame(stampAfter(40));
  ASSERT_TRUE(frame);
  EXPECT_GT(readField(*frame, end, "z"), 1e-4);

  SelectRegionRequest wrong = far_end;
  wrong.pose.position.x = 100.0;
  EXPECT_FALSE(client_->select("pin", wrong).success);
  wrong = far_end;
  wrong.primitive.type = shape_msgs::SolidPrimitive::CONE;
  EXPECT_FALSE(client_->select("pin", wrong).success);
  wrong = far_end;
  wrong.primitive.dimensions[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(client_->select("pin", wrong).success);
  wrong = far_end;
  wrong.pose.orientation.z = wrong.pose.orientation.w = std::sqrt(0.5);
  EXPECT_FALSE(client_->select("pin", wrong).success);
  wrong = far_end;
  wrong.header.frame_id = "nowhere";
  EXPECT_NE(client_->select("pin", wrong).message.find("nowhere"), std::string::npos);
}

TEST_F(CommandsTest, AppliesAWrenchUntilItsTimeout) {
  ASSERT_TRUE(startPaused());
  int num_arrows = -1;
  const ros::Subscriber markers = client_->handle().subscribe<visualization_msgs::MarkerArray>(
      "markers", 10, [&](const visualization_msgs::MarkerArrayConstPtr& m) {
        num_arrows = 0;
        for (const auto& marker : m->markers)
          num_arrows += marker.ns == "forces" && marker.action == visualization_msgs::Marker::ADD;
      });
  ASSERT_TRUE(waitUntil([&] { return num_arrows == 0; }));
  ros::Publisher wrench = client_->handle().advertise<geometry_msgs::WrenchStamped>("wrench", 10);
  ASSERT_TRUE(waitUntil([&] { return wrench.getNumSubscribers() > 0; }));
  geometry_msgs::WrenchStamped message;
  message.header.frame_id = "camera";
  message.wrench.force.z = 0.01;
  wrench.publish(message);
  ASSERT_TRUE(client_->waitForDiagnostic("commands waiting", 1));
  ASSERT_TRUE(client_->step(10).success);  // as long as the timeout
  EXPECT_TRUE(waitUntil([&] { return num_arrows == 1; }));
  ASSERT_TRUE(client_->step(1).success);
  EXPECT_TRUE(waitUntil([&] { return num_arrows == 0; }));
}

TEST_F(CommandsTest, TakesForcesAndGravityFromTheirFrames) {
  NodeProcess process("/tilted", kTurnedGravity);
  NodeClient client("/tilted");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  cloud_ = makeSurface(ros::Time::now());
  ASSERT_TRUE(client.exchange(cloud_));
  ASSERT_TRUE(waitUntil([&] { return client.diagnosticText("state") == "waiting for the transform of gravity_frame"; }));
  ASSERT_TRUE(client.pause(true).success);
  EXPECT_FALSE(client.step(1).success);

  // The camera looks down along the world's x: what falls in the world moves along the camera's x.
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "world";
  transform.header.stamp = ros::Time::now();
  transform.child_frame_id = "camera";
  transform.transform.rotation.y = transform.transform.rotation.w = std::sqrt(0.5);
  tf2_ros::StaticTransformBroadcaster broadcaster;
  broadcaster.sendTransform(transform);
  ASSERT_TRUE(waitUntil([&] { return client.diagnosticText("state") == "paused" && client.step(1).success; }));
  ASSERT_TRUE(client.step(9).success);
  auto frame = client.waitForFrame(stampAfter(10));
  ASSERT_TRUE(frame);
  const int free_point = 7 * kColumns + 3;
  const Vec3 fallen = readPosition(*frame, free_point) - readPosition(cloud_, free_point);
  EXPECT_NEAR(fallen.x(), 0.5 * 1.0 * 0.1 * 0.1, 1e-3);
  EXPECT_NEAR(fallen.z(), 0.0, 1e-6);

  // A force upwards in the world on all points, larger than the weight.
  ASSERT_TRUE(client.reset().success);
  PointForce lift = makeForce("lift", Vec3::Zero(), Vec3(0.0, 0.0, 1.0), 10.0);
  lift.header.frame_id = "world";
  client.publish(lift);
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 1));
  ASSERT_TRUE(client.step(20).success);
  frame = client.waitForFrame(stampAfter(20));
  ASSERT_TRUE(frame);
  const Vec3 lifted = readPosition(*frame, free_point) - readPosition(cloud_, free_point);
  EXPECT_LT(lifted.x(), -0.01);
  EXPECT_NEAR(lifted.z(), 0.0, 1e-4);
}

TEST_F(CommandsTest, GravityThatChangesIsTurnedAsLastKnown) {
  NodeProcess process("/turned", kTurnedGravity);
  NodeClient client("/turned");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  cloud_ = makeSurface(ros::Time::now());
  ASSERT_TRUE(client.exchange(cloud_));
  ASSERT_TRUE(client.pause(true).success);
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "world";
  transform.header.stamp = ros::Time::now();
  transform.child_frame_id = "camera";
  transform.transform.rotation.y = transform.transform.rotation.w = std::sqrt(0.5);
  tf2_ros::TransformBroadcaster broadcaster;
  ASSERT_TRUE(waitUntil([&] {
    broadcaster.sendTransform(transform);
    return client.step(1).success;
  }));
  // From here on tf knows none of the times of the steps.
  transform.header.stamp += ros::Duration(3600.0);
  transform.transform.rotation = geometry_msgs::Quaternion();
  transform.transform.rotation.w = 1.0;
  ASSERT_TRUE(client.reset().success);
  ASSERT_TRUE(client.step(1).success);
  broadcaster.sendTransform(transform);
  dynamic_reconfigure::Reconfigure change;
  change.request.config.doubles.resize(1);
  change.request.config.doubles[0].name = "gravity.z";
  change.request.config.doubles[0].value = -2.0;
  ASSERT_TRUE(ros::service::call("/turned/set_parameters", change));
  ASSERT_TRUE(client.step(9).success);
  const auto frame = client.waitForFrame(stampAfter(10));
  ASSERT_TRUE(frame);
  const int free_point = 7 * kColumns + 3;
  const Vec3 fallen = readPosition(*frame, free_point) - readPosition(cloud_, free_point);
  EXPECT_NEAR(fallen.x(), 0.5 * 2.0 * 0.1 * 0.1, 2e-3);
  EXPECT_NEAR(fallen.z(), 0.0, 1e-6);
}

TEST_F(CommandsTest, RefusesCommandsThatMeanNothing) {
  ASSERT_TRUE(startPaused());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<PointForce> wrong = {
      makeForce("", Vec3::Zero(), Vec3::UnitZ()), makeForce("a", Vec3(nan, 0, 0), Vec3::UnitZ()),
      makeForce("a", Vec3::Zero(), Vec3(0, nan, 0)), makeForce("a", Vec3::Zero(), Vec3::UnitZ(), -1.0),
      makeForce("a", Vec3::Zero(), Vec3::UnitZ(), 0.0, -1.0)};
  for (const PointForce& force : wrong) client_->publish(force);
  ASSERT_TRUE(client_->waitForDiagnostic("commands waiting", wrong.size()));
  const std::uint64_t commanded = client_->step(1).state_hash;
  EXPECT_TRUE(client_->waitForDiagnostic("commands refused", wrong.size()));
  ASSERT_TRUE(client_->reset().success);
  EXPECT_EQ(client_->step(1).state_hash, commanded);
}

TEST_F(CommandsTest, RefusesToolsThatMeanNothingAndLosesNothing) {
  ASSERT_TRUE(startPaused());
  ros::Publisher tools = client_->handle().advertise<ToolArray>("tools", 10);
  ASSERT_TRUE(waitUntil([&] { return tools.getNumSubscribers() > 0; }));
  const std::uint64_t before = client_->step(1).state_hash;
  ToolArray array;
  array.tools.resize(101);
  tools.publish(array);
  EXPECT_TRUE(client_->waitForDiagnostic("commands refused", 1));
  EXPECT_NE(client_->diagnosticText("last warning").find("found 101 tools in a message"), std::string::npos);
  array.tools.resize(2);
  array.tools[0].id = "no name";
  array.tools[1].id = "sieve";
  array.tools[1].shape = Tool::MESH;
  tools.publish(array);
  ASSERT_TRUE(client_->waitForDiagnostic("commands waiting", 2));
  ASSERT_TRUE(client_->step(1).success);
  EXPECT_TRUE(client_->waitForDiagnostic("commands refused", 3));
  EXPECT_NE(client_->diagnosticText("last warning").find("tool 'sieve' mesh.triangles: found 0;"), std::string::npos)
      << client_->diagnosticText("last warning");
  // No other surface is under construction that the command could be for.
  EXPECT_EQ(client_->diagnosticText("last warning").find("being built"), std::string::npos)
      << client_->diagnosticText("last warning");
  ASSERT_TRUE(client_->reset().success);
  EXPECT_EQ(client_->step(1).state_hash, before);
}

TEST_F(CommandsTest, ATableCarriesTheWeightAndSaysSoInBothFrames) {
  NodeProcess process("/lying", "{model: mass_spring, gravity: [0, 0, -2], integrator: {type: static}}");
  NodeClient client("/lying");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ros::Publisher tools = client.handle().advertise<ToolArray>("tools", 10);
  ToolWrenchArray wrenches;
  const ros::Subscriber all = client.handle().subscribe<ToolWrenchArray>(
      "tool_wrenches", 10, [&](const boost::shared_ptr<const ToolWrenchArray>& m) { wrenches = *m; });
  geometry_msgs::WrenchStamped wrench;
  const ros::Subscriber one = client.handle().subscribe<geometry_msgs::WrenchStamped>(
      "tools/table/wrench", 10, [&](const geometry_msgs::WrenchStampedConstPtr& m) { wrench = *m; });
  ContactArray contacts;
  const ros::Subscriber single = client.handle().subscribe<ContactArray>(
      "contacts", 10, [&](const boost::shared_ptr<const ContactArray>& m) { contacts = *m; });
  double mass = 0.0;
  const ros::Subscriber points =
      client.handle().subscribe<PointCloud2>("simulation_points", 10, [&](const sensor_msgs::PointCloud2ConstPtr& m) {
        mass = 0.0;
        for (std::size_t i = 0; i < m->width; ++i) mass += readField(*m, i, "mass");
      });
  ASSERT_TRUE(waitUntil([&] { return tools.getNumSubscribers() > 0 && all.getNumPublishers() > 0; }));
  ASSERT_TRUE(client.pause(true).success);
  cloud_ = makeSurface(ros::Time::now());
  ASSERT_TRUE(client.exchange(cloud_));

  // The table's own y axis is up, and so is its plane's normal.
  ToolArray array;
  array.tools.resize(1);
  Tool& table = array.tools[0];
  table.id = "table";
  table.shape = Tool::PLANE;
  table.plane.coef = {0.0, 1.0, 0.0, 0.0};
  table.pose.orientation.x = table.pose.orientation.w = std::sqrt(0.5);
  tools.publish(array);
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 1));
  ASSERT_TRUE(waitUntil([&] { return client.step(1).success && one.getNumPublishers() > 0; }));
  ASSERT_TRUE(waitUntil([&] { return client.step(1).success && wrench.header.frame_id == "camera" && mass > 0.0; }));
  const double weight = 2.0 * mass;
  EXPECT_NEAR(wrench.wrench.force.z, -weight, 1e-5 * weight);
  EXPECT_NEAR(wrench.wrench.force.x, 0.0, 1e-12 * weight);
  ASSERT_TRUE(waitUntil([&] { return wrenches.header.stamp >= wrench.header.stamp && !wrenches.wrenches.empty(); }));
  ASSERT_EQ(wrenches.wrenches.size(), 1u);
  EXPECT_EQ(wrenches.wrenches[0].id, "table");
  EXPECT_NEAR(wrenches.wrenches[0].wrench.force.y, -weight, 1e-5 * weight);
  EXPECT_GT(wrenches.wrenches[0].contacts, 0u);
  EXPECT_GT(wrenches.wrenches[0].penetration, 0.0);
  // At most 30 times per second of the surface's time: not after every step of 10 ms.
  ASSERT_TRUE(waitUntil([&] { return client.step(1).success && !contacts.contacts.empty(); }));
  double borne = 0.0;
  for (const Contact& contact : contacts.contacts) {
    EXPECT_EQ(contact.tool, "table");
    EXPECT_NEAR(contact.normal.z, 1.0, 1e-12);
    borne += contact.force.z;
  }
  EXPECT_NEAR(borne, weight, 1e-5 * weight);
  EXPECT_EQ(contacts.header.frame_id, "camera");

  array.tools[0].action = Tool::DELETE;
  tools.publish(array);
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 1));
  ASSERT_TRUE(waitUntil([&] {
    client.pause(true);
    client.step(1);
    return wrenches.wrenches.empty();
  }));
}

TEST_F(CommandsTest, TellsWhichCloudItShowsAndWhatBecameOfEachTool) {
  ToolStatusArray told;
  Statistics statistics;
  const ros::Subscriber statuses =
      client_->handle().subscribe<ToolStatusArray>("tool_status", 10, [&](const ToolStatusArray::ConstPtr& m) { told = *m; });
  const ros::Subscriber steps =
      client_->handle().subscribe<Statistics>("statistics", 100, [&](const StatisticsConstPtr& m) { statistics = *m; });
  ros::Publisher tools = client_->handle().advertise<ToolArray>("tools", 10);
  ASSERT_TRUE(waitUntil([&] { return tools.getNumSubscribers() > 0 && statuses.getNumPublishers() > 0; }));
  const auto isTold = [&](const std::string& id, std::uint8_t status, std::uint32_t sequence) {
    return waitUntil([&] {
      return std::any_of(told.tools.begin(), told.tools.end(), [&](const ToolStatus& tool) {
        return tool.id == id && tool.status == status && tool.header.seq == sequence;
      });
    });
  };
  ToolArray array;
  array.tools.resize(1);
  Tool& ball = array.tools[0];
  ball.id = "ball";
  ball.header.seq = 17;  // which the sender numbers
  ball.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
  ball.primitive.dimensions = {0.01};
  ball.pose.position.z = -1.0;
  tools.publish(array);
  EXPECT_TRUE(isTold("ball", ToolStatus::WAITING, 17));
  EXPECT_EQ(told.tools.at(0).message, "there is no surface yet");

  ASSERT_TRUE(startPaused());
  ASSERT_TRUE(waitUntil([&] { return statistics.cloud == 1; }));
  EXPECT_EQ(statistics.cloud_stamp, cloud_.header.stamp);
  EXPECT_EQ(statistics.cloud_frame, "camera");
  ASSERT_TRUE(client_->step(1).success);
  EXPECT_TRUE(isTold("ball", ToolStatus::ACCEPTED, 17));
  EXPECT_EQ(told.tools.at(0).step, 0u);

  ball.header.seq = 18;
  ball.primitive.dimensions = {-0.01};
  tools.publish(array);
  EXPECT_TRUE(isTold("ball", ToolStatus::WAITING, 18));
  ASSERT_TRUE(client_->step(1).success);
  EXPECT_TRUE(isTold("ball", ToolStatus::REFUSED, 18));
  EXPECT_NE(told.tools.at(0).message.find("radius"), std::string::npos) << told.tools.at(0).message;

  array.tools.resize(101);
  tools.publish(array);
  EXPECT_TRUE(isTold("", ToolStatus::REFUSED, 0));

  // Latched, for late subscribers.
  ToolStatusArray late;
  const ros::Subscriber other = ros::NodeHandle().subscribe<ToolStatusArray>(
      "/surface/tool_status", 10, [&](const ToolStatusArray::ConstPtr& m) { late = *m; });
  EXPECT_TRUE(waitUntil([&] { return late.tools.size() == 2; }));

  // The next cloud is another surface, which has no tools.
  PointCloud2 next = makeSurface(ros::Time::now());
  ASSERT_TRUE(client_->exchange(next)) << process_->output();
  ASSERT_TRUE(waitUntil([&] { return statistics.cloud == 2; }));
  EXPECT_EQ(statistics.cloud_stamp, next.header.stamp);
  EXPECT_TRUE(waitUntil([&] { return told.tools.empty(); }));
}

TEST_F(CommandsTest, TheWrenchOfAToolWhoseFrameIsSilentIsStaleAndKeepsItsStamp) {
  NodeProcess process("/silent", "{model: mass_spring, gravity: [0, 0, -1], input: {tool_timeout: 0.2}}");
  NodeClient client("/silent");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  ros::Publisher tools = client.handle().advertise<ToolArray>("tools", 10);
  ros::Publisher transforms = ros::NodeHandle().advertise<tf2_msgs::TFMessage>("/tf", 100);
  ToolWrenchArray wrenches;
  const ros::Subscriber all = client.handle().subscribe<ToolWrenchArray>(
      "tool_wrenches", 10, [&](const boost::shared_ptr<const ToolWrenchArray>& m) { wrenches = *m; });
  std::vector<ros::Time> stamps;
  const ros::Subscriber one = client.handle().subscribe<geometry_msgs::WrenchStamped>(
      "tools/palm/wrench", 1000, [&](const geometry_msgs::WrenchStampedConstPtr& m) { stamps.push_back(m->header.stamp); });
  ASSERT_TRUE(waitUntil([&] { return tools.getNumSubscribers() > 0 && transforms.getNumSubscribers() > 0; }));
  cloud_ = makeSurface(ros::Time::now());
  ASSERT_TRUE(client.exchange(cloud_)) << process.output();

  const auto tell = [&] {
    tf2_msgs::TFMessage message;
    message.transforms.resize(1);
    message.transforms[0].header.frame_id = "camera";
    message.transforms[0].header.stamp = ros::Time::now();
    message.transforms[0].child_frame_id = "palm";
    message.transforms[0].transform.translation.z = -0.05;
    message.transforms[0].transform.rotation.w = 1.0;
    transforms.publish(message);
  };
  ToolArray array;
  array.tools.resize(1);
  array.tools[0].header.frame_id = "palm";
  array.tools[0].id = "palm";
  array.tools[0].follow_frame = true;
  array.tools[0].shape = Tool::PLANE;
  array.tools[0].plane.coef = {0.0, 0.0, 1.0, 0.0};
  tell();
  tools.publish(array);
  ASSERT_TRUE(waitUntil([&] {
    tell();
    return stamps.size() > 20 && !wrenches.wrenches.empty() && !wrenches.wrenches[0].silent;
  })) << process.output();

  // Nobody publishes the transform of the palm any more.
  ASSERT_TRUE(waitUntil([&] { return !wrenches.wrenches.empty() && wrenches.wrenches[0].silent; })) << process.output();
  const ros::Time then = wrenches.header.stamp;
  ASSERT_TRUE(waitUntil([&] { return wrenches.header.stamp > then + ros::Duration(0.2); }));
  const std::size_t before = stamps.size();
  ASSERT_TRUE(waitUntil([&] { return stamps.size() > before + 10; }));
  EXPECT_EQ(stamps.back(), stamps[before]);
  EXPECT_LE(stamps.back(), then);
  EXPECT_TRUE(waitUntil([&] { return client.diagnosticText("silent tools") == "palm"; }));
  EXPECT_EQ(countOf("no transform of frame 'palm' for 0.2 s", process.output()), 1u) << process.output();

  ASSERT_TRUE(waitUntil([&] {
    tell();
    return !wrenches.wrenches[0].silent && stamps.back() > then;
  })) << process.output();
}

TEST_F(CommandsTest, TellsOfEveryCauseButNotOfEveryMessage) {
  ASSERT_TRUE(startPaused());
  client_->publish(makeForce("a", Vec3(0, std::numeric_limits<double>::quiet_NaN(), 0), Vec3::UnitZ()));
  for (const double radius : {-1.0, -0.5, -12.0, -1e-7}) client_->publish(makeForce("a", Vec3::Zero(), Vec3::UnitZ(), radius));
  client_->publish(makeForce("b", Vec3::Zero(), Vec3::UnitZ(), 0.0, -1.0));
  ASSERT_TRUE(client_->waitForDiagnostic("commands waiting", 6));
  ASSERT_TRUE(client_->step(1).success);
  const std::string output = process_->output();
  EXPECT_EQ(countOf("force 'a' point: found", output), 1u) << output;
  EXPECT_EQ(countOf("force 'a' radius: found", output), 1u) << output;
  EXPECT_EQ(countOf("force 'b' duration: found", output), 1u) << output;
}

TEST_F(CommandsTest, TellsOnceOfAForceThatActsFarAwayOrOnPinnedPointsOnly) {
  ASSERT_TRUE(startPaused());
  const auto pull = [&](double height) {
    client_->publish(makeForce("far1", Vec3(0.4, 0.1, height), 1e-3 * Vec3::UnitZ(), 0.05));
    client_->publish(makeForce("far2", Vec3(0.4, 0.1, -height), 1e-3 * Vec3::UnitZ(), 0.05));
    client_->publish(makeForce("held", Vec3(0.0, 0.1, 0.0), 1e-3 * Vec3::UnitZ(), 0.021));
    client_->publish(makeForce("good", Vec3(0.2, 0.1, 0.0), 1e-3 * Vec3::UnitZ(), 0.05));
    EXPECT_TRUE(client_->waitForDiagnostic("commands waiting", 4));
    EXPECT_TRUE(client_->step(1).success);
    EXPECT_TRUE(client_->waitForDiagnostic("commands waiting", 0));
  };
  pull(1.0);
  pull(2.0);
  const std::string output = process_->output();
  const std::string far_away = ": no simulation point lies within its radius of 0.05 m; it acts on the nearest one, 1 m from";
  EXPECT_EQ(countOf("force 'far1'" + far_away, output), 1u) << output;
  EXPECT_EQ(countOf("force 'far2'" + far_away, output), 1u) << output;
  EXPECT_EQ(countOf("force 'held': all", output), 1u) << output;
  EXPECT_EQ(countOf("force 'good'", output), 0u) << output;
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "commands_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
