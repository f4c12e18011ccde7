// Scenes of the package with their clouds, run without the readers of the room io that need PCL. The tests of whole figures share
// them.
#pragma once

#include "deformable_surface/base/error.h"
#include "deformable_surface/io/scene.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/simulation.h"
#include "shared_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

namespace deformable_surface::test {

/// The points of a text file: lines of x y z (.xyz), or those that begin with v (.obj). Empty without it.
inline Points readPoints(const std::string& file) {
  const bool is_obj = file.size() > 4 && file.compare(file.size() - 4, 4, ".obj") == 0;
  std::ifstream stream(file);
  Points points;
  for (std::string line; std::getline(stream, line);) {
    if (is_obj && line.compare(0, 2, "v ") != 0) continue;
    std::istringstream words(is_obj ? line.substr(2) : line);
    Vec3 p;
    if (words >> p.x() >> p.y() >> p.z()) points.push_back(p);
  }
  return points;
}

/// A file in the folder of shared data; empty if it is not there.
inline Points readSharedPoints(const std::string& name) { return readPoints(sharedFolder() + "/" + name); }

/// The faces (lines that begin with f) of an .obj file there.
inline std::vector<std::vector<Index>> readSharedFaces(const std::string& name) {
  std::ifstream stream(sharedFolder() + "/" + name);
  std::vector<std::vector<Index>> faces;
  for (std::string line; std::getline(stream, line);) {
    if (line.compare(0, 2, "f ") != 0) continue;
    std::istringstream words(line.substr(2));
    faces.emplace_back();
    for (std::string word; words >> word;)
      faces.back().push_back(static_cast<Index>(std::stol(word)) - 1);  // "1/2/3": position first
  }
  return faces;
}

inline simulation::SceneParams loadScene(const std::string& name) {
  return io::readScene(io::loadYamlFile(std::string(DEFORMABLE_SURFACE_SOURCE_DIR) + "/scenes/" + name + ".yaml"));
}

inline simulation::SceneParams parseScene(const std::string& text) { return io::readScene(io::parseYaml(text, "scene")); }

/// With the scene's own cloud.
inline simulation::Simulation makeSimulation(const simulation::SceneParams& scene) {
  if (scene.cloud.file.empty()) return {scene, io::makeShape(scene.cloud)};
  const std::string package = "package://deformable_surface/";
  cloud::PointCloud cloud;
  cloud.positions = readPoints(std::string(DEFORMABLE_SURFACE_SOURCE_DIR) + "/" + scene.cloud.file.substr(package.size()));
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  return {scene, cloud};
}

/// To the end of the scene.
inline void runScene(simulation::Simulation& s) {
  const long steps = std::lround(s.params().duration / s.params().integrator.time_step);
  for (long i = 0; i < steps; ++i) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
  }
}

/// The largest displacement of the points that were within the box at rest, m; NaN if there are none.
inline double findLargestMotion(simulation::Simulation& s, const Vec3& low, const Vec3& high) {
  const simulation::Surface& surface = s.surface(false);
  double largest = std::nan("");
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    const Vec3& at = s.input().positions[i];
    if ((at.array() < low.array()).any() || (at.array() > high.array()).any()) continue;
    largest = std::fmax(largest, surface.displacement[i]);
  }
  return largest;
}

}  // namespace deformable_surface::test
