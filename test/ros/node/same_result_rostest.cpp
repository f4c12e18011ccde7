// A scene through `simulate` and through the node gives the same bits. A real scan goes through the node as from a client.
#include "../node_client.h"

#include "deformable_surface/ToolArray.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/ros/convert/encode.h"

#include <rosbag/bag.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace deformable_surface::node::test {
namespace {

const char* const kScene =
    R"({model: mass_spring, cloud: {shape: cap, points: 3000, radius: 0.25, angle: 0.7}, simplification: {target_points: 300},
  gravity: [0, 0, -1], pins: [{box: {min: [-0.3, -0.3, -0.2194], max: [0.3, 0.3, 0.0]}}], duration: 0.4, material: {damping: 5},
  forces: [{id: pull, point: [0, 0, -0.25], force: [0, 0, 8], radius: 0.08, start: 0.05, end: 0.3}]})";

// A cloud with float64 coordinates, which lose nothing on the wire.
sensor_msgs::PointCloud2 toMessage(const cloud::PointCloud& cloud) {
  sensor_msgs::PointCloud2 message;
  message.header.frame_id = "world";
  message.header.stamp = ros::Time::now();
  message.width = static_cast<std::uint32_t>(cloud.size());
  message.height = 1;
  message.point_step = 24;
  message.row_step = message.width * message.point_step;
  for (int c = 0; c < 3; ++c) {
    sensor_msgs::PointField field;
    field.name = std::string(1, "xyz"[c]);
    field.offset = 8 * c;
    field.datatype = sensor_msgs::PointField::FLOAT64;
    field.count = 1;
    message.fields.push_back(field);
  }
  message.data.resize(message.row_step);
  std::memcpy(message.data.data(), cloud.positions.data(), message.data.size());
  return message;
}

// The hash of the last state, as printed by `simulate`.
std::string hashOfSimulate(const std::filesystem::path& scene, const std::string& options = "") {
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "simulate";
  FILE* output = popen((program + " " + scene.string() + options + " 2>&1").c_str(), "r");
  std::string text, hash;
  char line[512];
  while (std::fgets(line, sizeof line, output)) {
    text += line;
    if (std::string(line).rfind("state hash", 0) == 0) hash = std::string(line).substr(10);
  }
  EXPECT_EQ(pclose(output), 0) << text;
  const auto begin = hash.find_first_not_of(" "), end = hash.find_last_not_of(" \n");
  return begin == std::string::npos ? text : hash.substr(begin, end - begin + 1);
}

// Runs a scene of 40 steps both ways.
void expectSameResult(const std::string& node, const std::string& scene) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / ("scene" + std::to_string(getpid()) + ".yaml");
  std::ofstream(file) << scene;
  const std::string expected = hashOfSimulate(file);
  std::filesystem::remove(file);

  NodeProcess process(node, scene);
  NodeClient client(node);
  ASSERT_TRUE(client.waitForNode());
  ASSERT_TRUE(client.pause(true).success);
  ASSERT_TRUE(client.exchange(toMessage(io::makeShape(io::readScene(io::parseYaml(scene, "scene")).cloud))));
  const StepResponse found = client.step(40);
  EXPECT_TRUE(found.success) << found.message;
  char hash[17];
  std::snprintf(hash, sizeof hash, "%016lx", static_cast<unsigned long>(found.state_hash));
  EXPECT_EQ(expected, hash);
}

TEST(SameResult, OfOneSceneThroughSimulateAndThroughTheNode) { expectSameResult("/same", kScene); }

TEST(SameResult, OfPinsThatMove) {
  std::string scene = kScene;
  const std::string pin = "max: [0.3, 0.3, 0.0]}";
  scene.insert(scene.find(pin) + pin.size(),
               ", path: [{time: 0.1, position: [0, 0, 0]}, "
               "{time: 0.3, position: [0.02, 0, 0.01], orientation: [0, 0, 0.1, 0.995]}]");
  expectSameResult("/carried", scene);
}

TEST(SameResult, OfToolsThroughABagAndThroughTheNode) {
  NodeProcess process("/tools_same", kScene);
  NodeClient client("/tools_same");
  ASSERT_TRUE(client.waitForNode());
  ros::Publisher publisher = client.handle().advertise<ToolArray>("tools", 10);
  ASSERT_TRUE(waitUntil([&] { return publisher.getNumSubscribers() > 0; }));
  ASSERT_TRUE(client.pause(true).success);
  sensor_msgs::PointCloud2 cloud = toMessage(io::makeShape(io::readScene(io::parseYaml(kScene, "scene")).cloud));
  cloud.header.stamp += ros::Duration(1000.0);  // ahead of the clock: ~step takes up no time that has passed
  ASSERT_TRUE(client.exchange(cloud));

  // A ball comes, is pushed on with a twist between two steps, and goes; a hand grips and turns.
  ToolArray array;
  const auto add = [&](const char* id, double time, std::uint8_t mode, const Vec3& position) -> Tool& {
    array.tools.emplace_back();
    Tool& tool = array.tools.back();
    tool.header.frame_id = "world";
    tool.header.stamp = cloud.header.stamp + ros::Duration(time);
    tool.id = id;
    tool.mode = mode;
    tool.primitive.type = shape_msgs::SolidPrimitive::SPHERE;
    tool.primitive.dimensions = {0.05};
    tool.pose.position.x = position.x(), tool.pose.position.y = position.y(), tool.pose.position.z = position.z();
    return tool;
  };
  add("ball", 0.02, Tool::SOLID, Vec3(0.0, 0.0, -0.31)).friction = 0.3;
  add("ball", 0.065, Tool::SOLID, Vec3(0.0, 0.0, -0.29)).twist.angular.x = 2.0;
  array.tools.back().twist.linear.z = 0.1;
  add("hand", 0.1, Tool::MOVE, Vec3(0.1, 0.0, -0.23));
  add("hand", 0.2, Tool::MOVE, Vec3(0.1, 0.02, -0.25)).twist.angular.z = 1.0;
  add("ball", 0.3, Tool::SOLID, Vec3::Zero()).action = Tool::DELETE;

  const std::filesystem::path base = std::filesystem::temp_directory_path() / ("tools" + std::to_string(getpid()));
  const std::string scene = base.string() + ".yaml", bag_file = base.string() + ".bag";
  std::ofstream(scene) << kScene;
  {
    rosbag::Bag bag(bag_file, rosbag::bagmode::Write);
    bag.write("/deformable_surface/cloud_in", cloud.header.stamp, cloud);
    bag.write("/deformable_surface/tools", cloud.header.stamp, array);
  }
  const std::string expected = hashOfSimulate(scene, " --bag_in " + bag_file);
  const std::string without = hashOfSimulate(scene);
  std::filesystem::remove(scene);
  std::filesystem::remove(bag_file);

  publisher.publish(array);
  ASSERT_TRUE(client.waitForDiagnostic("commands waiting", array.tools.size()));
  const StepResponse found = client.step(40);
  EXPECT_TRUE(found.success) << found.message;
  char hash[17];
  std::snprintf(hash, sizeof hash, "%016lx", static_cast<unsigned long>(found.state_hash));
  EXPECT_EQ(expected, hash);
  EXPECT_NE(expected, without);
}

TEST(RealScan, KeepsItsOrderItsHolesAndItsColoursAndMovesWhereItIsPulled) {
  const char* folder = std::getenv("DEFORMABLE_SURFACE_DATA");
  if (!folder || !*folder) GTEST_SKIP() << "DEFORMABLE_SURFACE_DATA names no folder of real scans";
  const std::filesystem::path file = std::filesystem::path(folder) / "pcl_scans" / "milk_color.pcd";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  const cloud::PointCloud scan = io::readPointFile(file, 1.0, 10000000);
  ASSERT_GT(scan.size(), 1000);

  // As from a camera driver: float32, with the other fields of the file.
  simulation::Surface surface;
  surface.num_input = scan.size();
  surface.positions = scan.positions;
  surface.displacement.assign(scan.size(), 0.0f);
  cloud::PointCloud layout = scan;
  layout.normals.clear();
  sensor_msgs::PointCloud2 message;
  SurfaceEncoder(layout, false, false).encode(surface, message);
  message.header.frame_id = "camera";
  message.header.stamp = ros::Time::now();

  NodeProcess process("/scan",
                      "{model: mass_spring, gravity: [0, 0, 0], simplification: {target_points: 400}, material: {damping: 5}}");
  NodeClient client("/scan");
  ASSERT_TRUE(client.waitForNode());
  ASSERT_TRUE(client.pause(true).success);
  const auto rest = client.exchange(message);
  ASSERT_TRUE(rest);
  EXPECT_EQ(rest->width, message.width);
  EXPECT_EQ(rest->height, message.height);

  // Pull at a point in the middle of the list.
  std::size_t pulled = scan.size() / 2;
  while (!readPosition(message, pulled).allFinite()) ++pulled;
  const Vec3 at = readPosition(message, pulled), pull(0.0, 0.0, -0.2);
  client.publish(makeForce("pull", at, pull, 0.02));
  ASSERT_TRUE(waitUntil([&] {
    return client.step(1).success && client.frames.back()->header.stamp > message.header.stamp &&
           readField(*client.frames.back(), pulled, "displacement") > 1e-3;
  }));
  const sensor_msgs::PointCloud2& deformed = *client.frames.back();
  ASSERT_EQ(deformed.width * deformed.height, message.width * message.height);
  EXPECT_LT(readPosition(deformed, pulled).z(), at.z());
  for (std::size_t i = 0; i < static_cast<std::size_t>(scan.size()); ++i) {
    const Vec3 before = readPosition(message, i), now = readPosition(deformed, i);
    ASSERT_EQ(before.allFinite(), now.allFinite()) << i;
    if (before.allFinite()) {
      ASSERT_NEAR((now - before).norm(), readField(deformed, i, "displacement"), 1e-5) << i;
    }
    for (const cloud::ExtraField& field : scan.extra_fields) {
      if (field.type != cloud::ScalarType::kFloat32 || field.count != 1) continue;
      const auto found =
          std::find_if(deformed.fields.begin(), deformed.fields.end(), [&](const auto& f) { return f.name == field.name; });
      ASSERT_NE(found, deformed.fields.end()) << field.name;
      ASSERT_EQ(0, std::memcmp(&field.bytes[4 * i], &deformed.data[i * deformed.point_step + found->offset], 4)) << field.name;
    }
  }
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "same_result_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
