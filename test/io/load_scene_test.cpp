// A scene with the files that it names, by the public library alone: no ROS, no program.
#include "deformable_surface/io/load_scene.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/simulation/simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace deformable_surface::io {
namespace {

namespace fs = std::filesystem;

class LoadSceneTest : public testing::Test {
 protected:
  LoadSceneTest() {
    std::string name = (fs::temp_directory_path() / "scene_XXXXXX").string();
    folder_ = mkdtemp(name.data());
    std::ofstream cloud(folder_ / "sheet.xyz");
    for (int i = 0; i < 100; ++i) cloud << 0.1 * (i % 10) << ' ' << 0.1 * (i / 10) << " 0\n";
    // A tetrahedron with edges of a metre along the axes.
    std::ofstream(folder_ / "wedge.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::ofstream(file()) << R"(
model: mass_spring
duration: 0.1
gravity: [0, 0, 0]
cloud: {file: package://towels/sheet.xyz}
tools: [{id: wedge, mode: solid, shape: {mesh: {file: package://towels/wedge.obj, scale: 0.2}},
         path: [{time: 0.0, position: [0.3, 0.3, -0.25]}, {time: 0.1, position: [0.3, 0.3, -0.1]}]}]
)";
  }
  ~LoadSceneTest() override { fs::remove_all(folder_); }

  std::string file() const { return (folder_ / "scene.yaml").string(); }
  FindPackage finder() const {
    return [this](const std::string& package) {
      if (package != "towels") throw InputError("package '" + package + "': not found; accepted: towels");
      return folder_.string();
    };
  }

  fs::path folder_;
};

TEST_F(LoadSceneTest, ReadsCloudAndMeshesOfPackagesAndRuns) {
  const simulation::SceneParams params = loadScene(file(), {}, finder());
  ASSERT_EQ(params.tools.size(), 1u);
  ASSERT_TRUE(params.tools[0].shape.mesh);
  EXPECT_EQ(params.tools[0].shape.mesh->triangles().size(), 4u);
  EXPECT_NEAR(geometry::findLargestExtent(params.tools[0].shape), 0.2, 0.1);

  simulation::Simulation simulation(params, loadCloud(params, finder()));
  ASSERT_EQ(simulation.input().size(), 100);
  for (int step = 0; step < 10; ++step) ASSERT_TRUE(simulation.step().ok);
  const auto& points = simulation.surface(false).positions;
  const auto isLower = [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); };
  EXPECT_GT(std::max_element(points.begin(), points.end(), isLower)->z(), 1e-3);  // the tip has pushed it
}

TEST_F(LoadSceneTest, TakesAssignmentsAndMakesShapes) {
  const simulation::SceneParams params =
      loadScene(file(), {"cloud={shape: sheet, points: 64}", "tools=[]", "gravity=[0, 0, -1]"});
  EXPECT_TRUE(params.tools.empty());
  EXPECT_EQ(params.gravity.z(), -1.0);
  EXPECT_EQ(loadCloud(params).size(), 64);
}

TEST_F(LoadSceneTest, RefusesPackagesThatNobodyFinds) {
  EXPECT_THROW(loadScene(file()), InputError);
  EXPECT_THROW(loadScene(file(), {"tools.0.shape.mesh.file=package://linen/wedge.obj"}, finder()), InputError);
  const simulation::SceneParams params = loadScene(file(), {"cloud.file=package://linen/sheet.xyz"}, finder());
  EXPECT_THROW(loadCloud(params, finder()), InputError);
}

}  // namespace
}  // namespace deformable_surface::io
