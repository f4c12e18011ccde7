// Runs every scene file of the package to its end and checks its `expect` block.
#include "deformable_surface/base/error.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/io/scene.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/io/volume_files.h"
#include "deformable_surface/simulation/expectations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

namespace deformable_surface {
namespace {

const std::string kRoot = DEFORMABLE_SURFACE_SOURCE_DIR;

std::vector<std::string> listScenes() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kRoot + "/scenes"))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string findPackage(const std::string&) { return kRoot; }

simulation::Simulation makeSimulation(const simulation::SceneParams& params) {
  if (params.cloud.file.empty()) return {params, io::makeShape(params.cloud)};
  return {params, io::readPointFile(params.cloud.file, params.cloud.scale, params.input.max_points, findPackage)};
}

class Scenes : public testing::TestWithParam<std::string> {};

TEST_P(Scenes, RunToTheirEndAndDoWhatTheyPromise) {
  simulation::SceneParams params = io::readScene(io::loadYamlFile(kRoot + "/scenes/" + GetParam() + ".yaml"));
  io::readGuide(params.oriented_particles.guide, findPackage);
  io::checkForSimulate(params);
  simulation::Simulation simulation = makeSimulation(params);
  const long steps = std::lround(params.duration / params.integrator.time_step);
  for (long i = 0; i < steps; ++i) {
    const simulation::StepOutcome outcome = simulation.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
  }
  for (const std::string& violation : simulation::checkExpectations(simulation)) ADD_FAILURE() << violation;
  EXPECT_FALSE(params.expect.empty()) << "a scene promises something, or nobody notices when it breaks";
}

INSTANTIATE_TEST_SUITE_P(, Scenes, testing::ValuesIn(listScenes()), [](const auto& info) { return info.param; });

}  // namespace
}  // namespace deformable_surface
