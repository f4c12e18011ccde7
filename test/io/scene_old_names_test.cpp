// Scenes with the names of the previous version give the same bits as those with the new names, with a notice.
#include "deformable_surface/io/scene_old_names.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/io/scene.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/simulation.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace deformable_surface;
using namespace deformable_surface::io;

namespace {

simulation::SceneParams read(const std::string& text) { return readScene(parseYaml(text, "test.yaml")); }

struct Names {
  const char *old_names, *names;
  std::size_t num_notices;
};

// Each has values that are no defaults. Together they contain all old names.
const Names kScenes[] = {{R"(
model: mass_spring
cloud: {shape: sheet, points: 225, size: [0.3, 0.3]}
pins: [{box: {min: [-0.2, 0.149, -0.1], max: [0.2, 0.2, 0.1]}}]
neighbors: {geodesicness: 2}
activity: {sleep: always, tolerance: 2.0e-5, quiet_time: 0.03}
input: {keep_parts: 1, unheld: freeze, track_gain: 300, track_distance: 0.1}
expect: {springs: [1, 1e6], error_softening: [0, 1], track_residual: [0, 1], track_points: [0, 0]}
)",
                          R"(
model: mass_spring
cloud: {shape: sheet, points: 225, size: [0.3, 0.3]}
pins: [{box: {min: [-0.2, 0.149, -0.1], max: [0.2, 0.2, 0.1]}}]
neighbors: {geodesic_exponent: 2}
sleep: {mode: always, tolerance: 2.0e-5, quiet_time: 0.03}
input: {largest_parts: 1, unconstrained_parts: freeze, tracking_gain: 300, tracking_distance: 0.1}
expect: {error_stiffness: [0, 1], links: [1, 1e6], tracked_points: [0, 0], tracking_residual: [0, 1]}
)",
                          12},
                         {R"(
model: oriented_particles
cloud: {shape: lattice, points: 80, size: [1.0, 1.0]}
oriented_particles: {spacing: 0.1, fit: true, hold_below: 0.5, spin: 20.0}
expect: {born: [0, 1e6], gone: [0, 0]}
)",
                          R"(
model: oriented_particles
cloud: {shape: lattice, points: 80, size: [1.0, 1.0]}
oriented_particles: {spacing: 0.1, grow_surface: true, freeze_below: 0.5, axis_alignment_rate: 20.0}
expect: {added: [0, 1e6], removed: [0, 0]}
)",
                          5}};

std::uint64_t hashAfterSteps(const simulation::SceneParams& scene) {
  simulation::Simulation surface(scene, makeShape(scene.cloud));
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(surface.step().ok);
  return surface.stateHash();
}

std::string problemOf(const std::string& text) {
  try {
    read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST(OldNames, ReadAsTheNewOnesWithANoticeEach) {
  for (const Names& scene : kScenes) {
    const simulation::SceneParams before = read(scene.old_names), now = read(scene.names);
    EXPECT_EQ(printScene(before), printScene(now));
    EXPECT_EQ(before.notices.size(), scene.num_notices);
    EXPECT_TRUE(now.notices.empty());
  }
  EXPECT_EQ(read(kScenes[0].old_names).notices.front(),
            "activity.quiet_time is now called sleep.quiet_time; the old name goes with version 0.3");
}

TEST(OldNames, RunBitForBitAsTheNewOnes) {
  for (const Names& scene : kScenes) EXPECT_EQ(hashAfterSteps(read(scene.old_names)), hashAfterSteps(read(scene.names)));
}

TEST(OldNames, AreToldByTheSurface) {
  const simulation::SceneParams scene = read(kScenes[0].old_names);
  const simulation::Simulation surface(scene, makeShape(scene.cloud));
  for (const std::string& notice : scene.notices)
    EXPECT_EQ(std::count(surface.buildNotes().begin(), surface.buildNotes().end(), notice), 1) << notice;
}

TEST(OldNames, AreRefusedBesideTheNewOnes) {
  EXPECT_EQ(problemOf("{model: mass_spring, activity: {sleep: never}, sleep: {mode: always}}"),
            "activity.sleep: found beside sleep.mode, which is its new name; accepted: the new one alone");
  // A scene that states every default may be combined with one that has old names.
  const simulation::SceneParams scene = read("{model: mass_spring, activity: {sleep: never}, sleep: {mode: auto}}");
  EXPECT_EQ(scene.sleep.mode, simulation::Sleep::kNever);
  EXPECT_EQ(scene.notices.size(), 1u);
}

TEST(OldNames, OfASectionDoNotHideWhatIsWrongInIt) {
  EXPECT_NE(problemOf("{model: mass_spring, activity: {sleep: never, calm_time: 1}}").find("activity: unknown key"),
            std::string::npos);
  EXPECT_NE(problemOf("{model: mass_spring, activity: {sleep: never}, sleep: 3}").find("sleep: found 3; accepted: a map"),
            std::string::npos);
  EXPECT_NE(problemOf("{model: mass_spring, activity: {quiet_time: -1}}").find("sleep.quiet_time: found -1"), std::string::npos);
}

TEST(OldNames, OfQuantitiesHaveNewOnes) {
  EXPECT_EQ(findNewQuantity("springs"), "links");
  EXPECT_EQ(findNewQuantity("links"), "links");
}
