// A node with a sheet that is pinned at its first columns, as from a depth camera: the start of the tests of the node's parts.
#pragma once

#include "../bad_clouds.h"
#include "../node_client.h"

#include <filesystem>
#include <limits>
#include <memory>
#include <string>

namespace deformable_surface::node::test {

constexpr int kColumns = 21, kRows = 15;
constexpr int kHole = 7;  // every such point is one; since the columns are a multiple, whole columns are
constexpr double kSpacing = 0.02;

/// A sheet as from a depth camera: organised, float64, padded, with an extra field and holes. It lies in z = 0 from the origin
/// on. Its first columns are to be pinned.
inline sensor_msgs::PointCloud2 makeSurface(const ros::Time& stamp) {
  PointCloud2 cloud = makeSheet(kColumns, kRows, 32);
  cloud.header.stamp = stamp;
  cloud.header.frame_id = "camera";
  cloud.is_dense = false;
  cloud.fields = {makeField("intensity", 24), makeField("x", 0, PointField::FLOAT64), makeField("y", 8, PointField::FLOAT64),
                  makeField("z", 16, PointField::FLOAT64)};
  for (int i = 0; i < kColumns * kRows; ++i) {
    const bool is_hole = i % kHole == kHole - 1;
    write(cloud, 32 * i, kSpacing * (i % kColumns));
    write(cloud, 32 * i + 8, is_hole ? std::numeric_limits<double>::quiet_NaN() : kSpacing * (i / kColumns));
    write(cloud, 32 * i + 16, 0.0);
    write(cloud, 32 * i + 24, static_cast<float>(i));
  }
  return cloud;
}

inline std::size_t countOf(const std::string& part, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

class SurfaceNodeTest : public ::testing::Test {
 protected:
  SurfaceNodeTest()
      : directory_(std::filesystem::temp_directory_path() / ("deformable_surface_save_" + std::to_string(getpid()))) {
    std::filesystem::create_directory(directory_);
    process_ = std::make_unique<NodeProcess>("/surface", R"(
model: mass_spring
material: {young_modulus: 1.0e5, thickness: 0.001, damping: 1.0}
gravity: [0, 0, 0]
pins: [{box: {min: [-1, -1, -1], max: [0.021, 1, 1]}}]
force: {radius: 0.05, timeout: 0.1}
output: {publish_rate: 100.0, stamp: simulation}
save_directory: )" + directory_.string());
    client_ = std::make_unique<NodeClient>("/surface");
  }
  ~SurfaceNodeTest() override { std::filesystem::remove_all(directory_); }

  void SetUp() override { ASSERT_TRUE(client_->waitForNode()) << process_->output(); }

  // Stamps are simulation time, so that a frame identifies its step.
  /// Paused, so that only ~step moves the surface.
  sensor_msgs::PointCloud2ConstPtr startPaused() {
    EXPECT_TRUE(client_->pause(true).success);
    cloud_ = makeSurface(ros::Time::now());
    return client_->exchange(cloud_);
  }
  ros::Time stampAfter(int steps) const { return cloud_.header.stamp + ros::Duration().fromNSec(10'000'000LL * steps); }

  std::filesystem::path directory_;
  std::unique_ptr<NodeProcess> process_;
  std::unique_ptr<NodeClient> client_;
  PointCloud2 cloud_;
};

}  // namespace deformable_surface::node::test
