// A recording through `rosbag play` and the node, in real time, against the same through `simulate`, offline: hash for hash. What
// is played comes by several connections at once, and the node keeps it in order by stamps alone.
#include "bad_clouds.h"
#include "node_client.h"

#include "deformable_surface/ToolArray.h"

#include <geometry_msgs/TransformStamped.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdlib>
#include <map>

namespace deformable_surface::node::test {
namespace {

constexpr double kStart = 100.0, kEnd = 106.0;  // s
// Steps stay behind the clock by more than messages take on a machine that does other things, too.
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
    // Recorded a tenth of a second later than they are stamped, as what sensors and networks bring.
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
  // The clock goes on to here.
  bag.write("/last", ros::Time(kEnd), tf2_msgs::TFMessage());
}

// Hashes by step.
std::map<std::uint64_t, std::uint64_t> simulateBag(const std::string& file) {
  const std::string scene = file + ".yaml", output = file + ".out.bag";
  std::ofstream(scene) << kScene;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "simulate";
  const std::string command =
      program + " " + scene + " --bag_in " + file + " --bag_out " + output +
      " --topic cloud_in=/played/cloud_in --topic force=/played/force --topic tools=/played/tools --duration 2 --quiet";
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  std::map<std::uint64_t, std::uint64_t> hashes;
  {
    const rosbag::Bag bag(output);
    for (const rosbag::MessageInstance& message : rosbag::View(bag))
      if (const auto statistics = message.instantiate<Statistics>()) hashes[statistics->step] = statistics->state_hash;
  }
  std::filesystem::remove(scene);
  std::filesystem::remove(output);
  return hashes;
}

TEST(RosbagPlay, GivesTheHashesOfSimulateStepByStepIfNothingWasLost) {
  const std::string file = std::filesystem::temp_directory_path() / ("played" + std::to_string(getpid()) + ".bag");
  writeBag(file);
  const std::map<std::uint64_t, std::uint64_t> expected = simulateBag(file);
  ASSERT_GE(expected.size(), 200u);

  NodeProcess process("/played", kScene);
  NodeClient client("/played");
  ASSERT_TRUE(client.waitForNode()) << process.output();
  std::map<std::uint64_t, std::uint64_t> found;
  const ros::Subscriber statistics = client.handle().subscribe<Statistics>("statistics", 10000, [&](const StatisticsConstPtr& m) {
    found[m->step] = m->state_hash;
  });
  ASSERT_TRUE(waitUntil([&] { return statistics.getNumPublishers() > 0; }));
  // The player waits for those who listen, and then plays at the pace of the recording.
  ASSERT_EQ(std::system(("rosbag play --clock --quiet -d 3 " + file + " > /dev/null").c_str()), 0);
  std::filesystem::remove(file);
  ASSERT_TRUE(waitUntil([&] { return client.diagnostic("step") > 200; })) << process.output();
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", 0));

  // What was lost is counted: nothing.
  for (const char* loss : {"commands late", "commands dropped", "commands refused", "clouds replaced before they were built",
                           "time not caught up (s)", "clock jumps back"})
    EXPECT_EQ(client.diagnostic(loss), 0.0) << loss << process.output();
  EXPECT_EQ(client.diagnostic("commands applied"), 49 + 7);
  std::size_t compared = 0;
  for (const auto& [step, hash] : expected) {
    const auto same = found.find(step);
    if (same == found.end()) continue;  // a frame that was dropped
    ++compared;
    EXPECT_EQ(same->second, hash) << "step " << step;
  }
  EXPECT_GT(compared, 20u);
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "rosbag_play_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
