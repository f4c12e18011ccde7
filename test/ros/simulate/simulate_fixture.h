// `simulate` as a function on files in a folder of its own: the start of its tests.
#pragma once

#include "../../../src/ros/simulate/simulate.h"

#include "deformable_surface/PointForce.h"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

namespace deformable_surface::node::test {

namespace fs = std::filesystem;

constexpr char kScene[] =
    "model: mass_spring\n"
    "cloud: {shape: sheet, points: 100}\n"
    "simplification: {target_points: 40}\n"
    "gravity: [0.0, 0.0, 0.0]\n"
    "duration: 0.1\n";
constexpr double kStart = 100.0;  // s, stamp of the cloud in the bags

inline std::string readFile(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline std::size_t countLines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

class Simulate : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("simulate_test_" + std::to_string(getpid()) + "_" + info->name());
    fs::create_directories(folder_);
    std::ofstream(path("scene.yaml")) << kScene;
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Runs the scene with these arguments.
  int run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), path("scene.yaml"));
    return runWithoutScene(arguments);
  }
  int runWithoutScene(const std::vector<std::string>& arguments) {
    std::ostringstream out, err;
    const int status = simulate(arguments, {out, err, false, stop_});
    out_ = out.str();
    err_ = err.str();
    return status;
  }

  /// The number of files whose names end like this.
  int countFiles(const std::string& ending) const {
    int count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      const std::string name = entry.path().string();
      count += name.size() >= ending.size() && name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
    }
    return count;
  }

  /// A square sheet in the frame "sheet", and whatever the caller adds.
  template <class Fill>
  void writeBag(const std::string& name, const Fill& fill) {
    rosbag::Bag bag(path(name), rosbag::bagmode::Write);
    bag.write("/deformable_surface/cloud_in", ros::Time(kStart), makeCloud(ros::Time(kStart)));
    fill(bag);
  }
  static sensor_msgs::PointCloud2 makeCloud(const ros::Time& stamp) {
    sensor_msgs::PointCloud2 cloud;
    cloud.header.frame_id = "sheet";
    cloud.header.stamp = stamp;
    sensor_msgs::PointCloud2Modifier modifier(cloud);
    modifier.setPointCloud2FieldsByString(1, "xyz");
    modifier.resize(100);
    sensor_msgs::PointCloud2Iterator<float> x(cloud, "x");
    for (int i = 0; i < 100; ++i, ++x) {
      x[0] = 0.1f * static_cast<float>(i % 10);
      x[1] = 0.1f * static_cast<float>(i / 10);
      x[2] = 0.0f;
    }
    return cloud;
  }
  static PointForce makeForce(double stamp, double z, double duration = 0.0) {
    PointForce force;
    force.header.stamp = ros::Time(stamp);
    force.id = "pull";
    force.point.x = 0.45;
    force.point.y = 0.45;
    force.force.z = z;
    force.radius = 2.0;  // all points, so that the sheet moves like a rigid body
    force.duration = duration;
    return force;
  }

  StopSignal stop_;
  fs::path folder_;
  std::string out_, err_;
};

}  // namespace deformable_surface::node::test
