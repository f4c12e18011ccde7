// A surface that rests in another shape than its own is reported. The demo's surface returns from any pull by hand.
#include "clouds.h"
#include "deformable_surface/io/scene.h"
#include "deformable_surface/io/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <stdexcept>
#include <string>

namespace deformable_surface::test {
namespace {

struct Drag {
  Vec3 place, way;  // m
  double time;      // s
};

simulation::SceneParams readDemo() {
  simulation::SceneParams params =
      io::readScene(io::loadYamlFile(std::string(DEFORMABLE_SURFACE_SOURCE_DIR) + "/scenes/demo.yaml"));
  params.accuracy.estimate = false;  // not needed here, and as expensive as the rest
  return params;
}

/// Force at which a pull slips, as in launch/demo.launch, N.
double readStrength() {
  std::ifstream file(DEFORMABLE_SURFACE_SOURCE_DIR "/launch/demo.launch");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::smatch found;
  if (!std::regex_search(text, found, std::regex("/strength\"[^>]*value=\"([0-9.]+)\"")))
    throw std::runtime_error("demo.launch sets no strength");
  return std::stod(found[1]);
}

/// Pulls the surface as the interactive markers do, holds it for a moment and releases it. Runs until all of it sleeps.
/// strength: force at which the pull slips, N; 0: never.
void drag(simulation::Simulation& s, const Drag& drag, double strength) {
  tool::ToolParams hand;
  hand.id = "hand";
  hand.mode = tool::Mode::kMove;
  hand.shape.radius = 0.025;  // one and a half spacings
  hand.strength = strength;
  hand.path = {{s.time(), drag.place}, {s.time() + drag.time, drag.place + drag.way}};
  s.setTool(hand);
  run(s, static_cast<int>(100 * (drag.time + 0.3)));
  s.removeTool("hand");
  for (int k = 0; k < 1000 && !s.isAsleep(); ++k) run(s, 1);
  EXPECT_TRUE(s.isAsleep());
}

double findDisplacement(const simulation::Simulation& s, const Points& rest) {
  double largest = 0.0;
  for (std::size_t i = 0; i < rest.size(); ++i) largest = std::max(largest, (s.state().positions[i] - rest[i]).norm());
  return largest;
}

// The first and the last left a shell with a third of the demo's thickness crumpled permanently.
const std::vector<Drag> kDrags = {{{-0.031, 0.017, 0.146}, {0.083, -0.012, 0.057}, 0.2},
                                  {{0.148, 0.0, 0.02}, {-0.2, 0.1, 0.05}, 0.5},
                                  {{0.0, -0.11, 0.1}, {0.15, -0.2, 0.1}, 1.0},
                                  {{0.021, 0.051, 0.139}, {-0.051, -0.018, -0.234}, 0.79}};

TEST(Snapped, TheDemoComesBackFromWhereverItIsDrawn) {
  const simulation::SceneParams params = readDemo();
  simulation::Simulation s(params, io::makeShape(params.cloud));
  const Points rest = s.state().positions;
  const double strength = readStrength();
  ASSERT_GT(strength, 0.0);  // without slip, rounding decides whether the third one crumples this shell
  for (const Drag& way : kDrags) {
    drag(s, way, strength);
    EXPECT_LT(findDisplacement(s, rest), 1e-4) << way.place.transpose();
    EXPECT_FALSE(s.hasSnapped());
  }
}

TEST(Snapped, AShellThatRestsCrumpledIsToldOf) {
  simulation::SceneParams params = readDemo();
  params.material.young_modulus = 2.0e5;
  params.material.thickness = 0.006;
  params.material.density = 400.0;
  params.material.damping = 10.0;
  simulation::Simulation s(params, io::makeShape(params.cloud));
  const Points rest = s.state().positions;
  EXPECT_FALSE(s.hasSnapped());
  drag(s, kDrags.back(), 0.0);
  ASSERT_GT(findDisplacement(s, rest), 0.05);
  EXPECT_TRUE(s.hasSnapped());
  EXPECT_TRUE(s.statistics().has_snapped);

  // A loaded surface may be bent by its load.
  simulation::ForceParams force;
  force.id = "push";
  force.point = Vec3(0.15, 0.0, 0.0);
  force.force = Vec3(-1e-6, 0.0, 0.0);
  s.setForce(force);
  run(s, 1);
  EXPECT_FALSE(s.hasSnapped());

  s.reset();
  EXPECT_FALSE(s.hasSnapped());
}

TEST(Snapped, WhatHangsInItsWeightIsNot) {
  simulation::SceneParams params = hangingSheet();
  params.material.damping = 10.0;
  simulation::Simulation s(params, sheetCloud());
  for (int k = 0; k < 2000 && !s.isAsleep(); ++k) run(s, 1);
  ASSERT_TRUE(s.isAsleep());
  ASSERT_GT(s.statistics().max_stretch, 1e-3);
  EXPECT_FALSE(s.hasSnapped());
}

}  // namespace
}  // namespace deformable_surface::test
