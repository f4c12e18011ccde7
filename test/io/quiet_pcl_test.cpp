#include "../../src/io/quiet_pcl.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/io/cloud_filters.h"
#include "deformable_surface/io/point_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>

using namespace deformable_surface;
using pcl::console::getVerbosityLevel;

namespace {

namespace fs = std::filesystem;

class QuietPcl : public testing::Test {
 protected:
  void SetUp() override { pcl::console::setVerbosityLevel(pcl::console::L_WARN); }
};

TEST_F(QuietPcl, LastsAsLongAsTheLastObject) {
  auto first = std::make_unique<io::QuietPcl>();
  const auto second = std::make_unique<io::QuietPcl>();
  first.reset();
  EXPECT_EQ(getVerbosityLevel(), pcl::console::L_ALWAYS);
}

TEST_F(QuietPcl, FilesAndFiltersLeaveItAsItWas) {
  const fs::path file = fs::temp_directory_path() / ("quiet_pcl_test_" + std::to_string(getpid()) + ".ply");
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  std::ofstream(file) << head << "0 0 0\n1 0 0\n0 1 0\n";
  cloud::PointCloud cloud = io::readPointFile(file.string(), 1.0, 10);
  EXPECT_EQ(getVerbosityLevel(), pcl::console::L_WARN);
  fs::remove(file);

  simulation::InputFilterParams params;
  params.outliers.method = simulation::OutlierParams::Method::kRadius;
  params.outliers.radius = 2.0;
  params.outliers.neighbors = 1;
  io::filterCloud(params, cloud);
  EXPECT_EQ(getVerbosityLevel(), pcl::console::L_WARN);
}

}  // namespace
