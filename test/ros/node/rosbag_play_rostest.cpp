// A recording through `rosbag play` and the node in real time, against the same recording through `simulate`: equal hashes. The
// messages come over several connections. The node orders them by stamps alone.
#include "../bad_clouds.h"
#include "../node_client.h"

#include "deformable_surface/ToolArray.h"

#include <geometry_msgs/TransformStamped.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <rosgraph_msgs/Clock.h>
#include <shape_msgs/SolidPrimitive.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdlib>
#include <map>
#include <set>

namespace deformable_surface::node::test {
namespace {

constexpr double kStart = 100.0, kEnd = 106.0;  // s
// Steps lag the clock by more than messages take on a busy machine.
constexpr char kScene[] = R"({model: mass_spring, gravity: [0, 0, -1], pins: [{box: {min: [-1, -1, -1], max: [0.011, 1, 1]}}],
                              material: {damping: 1}, output: {publish_rate: 100.0}, input: {delay: 3.0}})";

void writeBag(const std::string& file) {
  rosbag::Bag bag(file, rosbag::bagmode::Write);
  PointCloud2 cloud = makeSheet(20, 10);
  cloud.header.stamp = ros::Time(kStart);
  cloud.header.frame_id = "table";
  bag.write("/played/cloud_in", cloud.header.stamp, cloud);
  for (int k = 0; k < 60; ++k) {
    const ros::Time stamp(kStart + 0.02 + 0.04 * k);
    tf2_msgs::TFMessage transforms;
    transforms.transforms.resize(1);
    transforms.transforms[0].header.frame_id = "table";
    transforms.transforms[0].header.stamp = stamp;
    transforms.transforms[0].child_frame_id = "hand";
    transforms.transforms[0].transform.translation.x = 0.05 + 0.001 * k;
    transforms.transforms[0].transform.rotation.w = 1.0;
    bag.write("/tf", stamp, transforms);
    // Recorded a tenth of a second after their stamps, as with delays of sensors and networks.
    PointForce force = makeForce("pull", Vec3(0.05, 0.05, 0.0), Vec3(0.0, 0.001 * (k % 5), 0.002), 0.03, 0.03);
    force.header.frame_id = "hand";
    force.header.stamp = stamp + ros::Duration(0.004);
    if (k > 0 && k < 50) bag.write("/played/force", force.header.stamp + ros::Duration(0.1), force);
    if (k == 1) {
      ToolArray fingers;
      fingers.tools.resize(1);
      Tool& finger = fingers.tools[0];
      finger.header.frame_id = "hand";
      finger.header.stamp = stamp;
      finger.id = "finger";
      finger.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
      finger.primitive.dimensions = {0.01};
      finger.pose.position.x = 0.08;
      finger.pose.position.y = 0.02;
      finger.pose.position.z = -0.013;
      finger.follow_frame = true;
      finger.friction = 0.3;
      bag.write("/played/tools", stamp + ros::Duration(0.05), fingers);
    }
    if (k % 10 != 5) continue;
    ToolArray tools;
    tools.tools.resize(1);
    tools.tools[0].header.frame_id = "table";
    tools.tools[0].header.stamp = stamp;
    tools.tools[0].id = "ball";
    tools.tools[0].primitive.type = shape_msgs::SolidPrimitive::SPHERE;
    tools.tools[0].primitive.dimensions = {0.02};
    tools.tools[0].pose.position.x = 0.15;
    tools.tools[0].pose.position.y = 0.05;
    tools.tools[0].pose.position.z = -0.02 + 1e-4 * k;
    bag.write("/played/tools", stamp + ros::Duration(0.05), tools);
  }
  // The clock continues up to this time.
  bag.write("/last", ros::Time(kEnd), tf2_msgs::TFMessage());
}

using Hashes = std::map<std::uint64_t, std::uint64_t>;  // by step

Hashes simulateBag(const std::string& file, const std::string& text, const std::string& options) {
  const std::string scene = file + ".yaml", output = file + ".out.bag";
  std::ofstream(scene) << text;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "simulate";
  const std::string command = program + " " + scene + " --bag_in " + file + " --bag_out " + output +
                              " --topic cloud_in=/played/cloud_in --topic force=/played/force --topic tools=/played/tools" +
                              " --quiet " + options;
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  Hashes hashes;
  {
    const rosbag::Bag bag(output);
    for (const rosbag::MessageInstance& message : rosbag::View(bag))
      if (const auto statistics = message.instantiate<Statistics>()) hashes[statistics->step] = statistics->state_hash;
  }
  std::filesystem::remove(scene);
  std::filesystem::remove(output);
  return hashes;
}

std::size_t compare(const Hashes& expected, const Hashes& found) {
  std::size_t compared = 0;
  for (const auto& [step, hash] : expected) {
    const auto same = found.find(step);
    if (same == found.end()) continue;  // a frame that was dropped
    ++compared;
    EXPECT_EQ(same->second, hash) << "step " << step;
  }
  return compared;
}

void expectNoLoss(const NodeClient& client, const NodeProcess& process) {
  for (const char* loss : {"commands late", "commands dropped", "commands refused", "clouds replaced before they were built",
                           "time not caught up (s)", "clock jumps back"})
    EXPECT_EQ(client.diagnostic(loss), 0.0) << loss << process.output();
}

TEST(RosbagPlay, GivesTheHashesOfSimulateStepByStepIfNothingWasLost) {
  const std::string file = std::filesystem::temp_directory_path() / ("played" + std::to_string(getpid()) + ".bag");
  writeBag(file);
  const Hashes expected = simulateBag(file, kScene, "--duration 2");
  ASSERT_GE(expected.size(), 200u);

  NodeProcess process("/played", kScene);
  NodeClient client("/played");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  Hashes found;
  const ros::Subscriber statistics = client.handle().subscribe<Statistics>(
      "statistics", 10000, [&](const StatisticsConstPtr& m) { found[m->step] = m->state_hash; });
  ASSERT_TRUE(waitUntil([&] { return statistics.getNumPublishers() > 0; }));
  // The player waits for subscribers, and then plays at the pace of the recording.
  ASSERT_EQ(std::system(("rosbag play --clock --quiet -d 3 " + file + " > /dev/null").c_str()), 0);
  std::filesystem::remove(file);
  ASSERT_TRUE(waitUntil([&] { return client.diagnostic("step") > 200; })) << process.output();
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 0));

  // Lost messages are counted: there are none.
  expectNoLoss(client, process);
  EXPECT_EQ(client.diagnostic("commands applied"), 49 + 7);
  EXPECT_GT(compare(expected, found), 20u);
}

// ---- Commands without a stamp, on a frame that moves ----

constexpr double kLongStep = 0.1;  // s: what is sent in the middle of a step arrives in it
constexpr int kLongSteps = 110, kDeparture = 3;
std::string makeLongScene(const std::string& more) {
  return R"({model: mass_spring, gravity: [0, 0, -0.2], pins: [{box: {min: [-1, -1, -1], max: [0.011, 1, 1]}}],
             material: {damping: 3}, integrator: {time_step: 0.1}, output: {publish_rate: 10.0}, duration: 11.0, )" +
         more + "}";
}

PointCloud2 makePlayedCloud() {
  PointCloud2 cloud = makeSheet(20, 10);
  cloud.header.stamp = ros::Time(kStart);
  cloud.header.frame_id = "table";
  return cloud;
}

tf2_msgs::TFMessage makeHand(int k) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(1);
  geometry_msgs::TransformStamped& hand = message.transforms[0];
  hand.header.frame_id = "table";
  hand.header.stamp = ros::Time(kStart + kLongStep * k);
  hand.child_frame_id = "hand";
  hand.transform.translation.x = 0.06 + 0.001 * k;
  hand.transform.translation.y = 0.05;
  hand.transform.translation.z = -0.001 * (k % 7);
  hand.transform.rotation.w = 1.0;
  return message;
}

PointForce makeHandForce(int k) {
  PointForce force = makeForce("push" + std::to_string(k), Vec3::Zero(), Vec3(0.0, 0.001 * (k % 3), 0.002), 0.02, 0.5);
  force.header.frame_id = "hand";
  return force;
}

// A grip that closes at the place of the hand and is moved by later commands.
ToolArray makeGrip() {
  ToolArray array;
  array.tools.resize(1);
  Tool& grip = array.tools[0];
  grip.header.frame_id = "hand";
  grip.id = "grip";
  grip.mode = Tool::MOVE;
  grip.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
  grip.primitive.dimensions = {0.03};
  return array;
}

bool hasForce(int k) { return k % 10 == kDeparture; }
bool hasGrip(int k) { return k == 37 || k == 48 || k == 71; }

TEST(RosbagPlay, GivesTheHashesOfSimulateForCommandsWithoutAStampOnAFrameThatMoves) {
  const std::string file = std::filesystem::temp_directory_path() / ("stampless" + std::to_string(getpid()) + ".bag");
  int commands = 0;
  {
    rosbag::Bag bag(file, rosbag::bagmode::Write);
    bag.write("/played/cloud_in", ros::Time(kStart), makePlayedCloud());
    for (int k = 0; k <= kLongSteps + 40; ++k) {
      const ros::Time on_step(kStart + kLongStep * k), between = on_step + ros::Duration(0.5 * kLongStep);
      bag.write("/tf", on_step, makeHand(k));
      if (k > kLongSteps) continue;
      if (hasForce(k)) bag.write("/played/force", between, makeHandForce(k));
      if (hasGrip(k)) bag.write("/played/tools", between, makeGrip());
      commands += hasForce(k) + hasGrip(k);
    }
  }
  const Hashes expected = simulateBag(file, makeLongScene("input: {delay: 3.0}"), "");
  ASSERT_EQ(expected.size(), kLongSteps + 1u);

  NodeProcess process("/played", makeLongScene("input: {delay: 3.0}"));
  NodeClient client("/played");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  Hashes found;
  const ros::Subscriber statistics = client.handle().subscribe<Statistics>(
      "statistics", 10000, [&](const StatisticsConstPtr& m) { found[m->step] = m->state_hash; });
  ASSERT_TRUE(waitUntil([&] { return statistics.getNumPublishers() > 0; }));
  ASSERT_EQ(std::system(("rosbag play --clock --hz=1000 --quiet -d 3 " + file + " > /dev/null").c_str()), 0);
  std::filesystem::remove(file);
  ASSERT_TRUE(waitUntil([&] { return found.count(kLongSteps) > 0; })) << process.output();
  ASSERT_TRUE(waitUntil([&] { return client.diagnostic("commands applied") >= commands; }));
  expectNoLoss(client, process);
  EXPECT_GT(compare(expected, found), 100u);
}

// The same live, recorded as it is sent, and the replay of that recording. The clock stops while a message is on its way.
TEST(RosbagPlay, ASimulatedRecordingGivesTheHashesOfTheLiveRun) {
  const std::string file = std::filesystem::temp_directory_path() / ("live" + std::to_string(getpid()) + ".bag");
  NodeProcess process("/live", makeLongScene("frame_id: table"));
  NodeClient client("/live");
  ros::NodeHandle node;
  ros::Publisher clock = node.advertise<rosgraph_msgs::Clock>("/clock", 1000);
  ros::Publisher transforms = node.advertise<tf2_msgs::TFMessage>("/tf", 100);
  ros::Publisher tools = client.handle().advertise<ToolArray>("tools", 100);
  ASSERT_TRUE(client.waitForNode()) << process.output();
  Hashes found;
  const ros::Subscriber statistics = client.handle().subscribe<Statistics>(
      "statistics", 10000, [&](const StatisticsConstPtr& m) { found[m->step] = m->state_hash; });
  ASSERT_TRUE(waitUntil([&] {
    return statistics.getNumPublishers() > 0 && clock.getNumSubscribers() >= 2 && transforms.getNumSubscribers() > 0 &&
           tools.getNumSubscribers() > 0;
  })) << process.output();
  {
    rosbag::Bag bag(file, rosbag::bagmode::Write);
    const auto tick = [&](int k) {
      rosgraph_msgs::Clock message;
      message.clock = ros::Time(kStart + kLongStep * k);
      clock.publish(message);
      return message.clock;
    };
    // tf does not acknowledge, but a service that uses the transform does.
    const auto hasArrived = [&](const tf2_msgs::TFMessage& message) {
      SelectRegionRequest far;
      far.header.frame_id = "hand";
      far.header.stamp = message.transforms[0].header.stamp;
      far.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
      far.primitive.dimensions = {0.001};
      far.pose.position.x = 100.0;
      return client.select("unpin", far).message.find("there is no transform") == std::string::npos;
    };
    tick(0);
    const PointCloud2 cloud = makePlayedCloud();
    bag.write("/played/cloud_in", ros::Time(kStart), cloud);
    ASSERT_TRUE(client.exchange(cloud)) << process.output();
    int waiting = 0;
    for (int k = 0; k <= kLongSteps; ++k) {
      const ros::Time now = tick(k);
      ASSERT_TRUE(waitUntil([&] { return k == 0 || found.count(k) > 0; })) << k << process.output();
      const tf2_msgs::TFMessage hand = makeHand(k);
      transforms.publish(hand);
      bag.write("/tf", now, hand);
      if (!hasForce(k) && !hasGrip(k)) continue;
      ASSERT_TRUE(waitUntil([&] { return hasArrived(hand); })) << process.output();
      ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 0));
      waiting = hasForce(k) + hasGrip(k);
      if (hasForce(k)) client.publish(makeHandForce(k));
      if (hasForce(k)) bag.write("/played/force", now, makeHandForce(k));
      if (hasGrip(k)) tools.publish(makeGrip());
      if (hasGrip(k)) bag.write("/played/tools", now, makeGrip());
      ASSERT_TRUE(client.waitForDiagnostic("commands waiting", waiting)) << process.output();
    }
    for (int k = kLongSteps + 1; k <= kLongSteps + 40; ++k) bag.write("/tf", ros::Time(kStart + kLongStep * k), makeHand(k));
  }
  expectNoLoss(client, process);
  const Hashes expected = simulateBag(file, makeLongScene("frame_id: table"), "");
  std::filesystem::remove(file);
  EXPECT_GE(compare(expected, found), 100u);
  EXPECT_GT(std::set<std::uint64_t>({expected.at(30), expected.at(60), expected.at(90)}).size(), 2u);
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "rosbag_play_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
