// A viewer of a running simulation shows everything that is published, bit for bit, from a thread of its own.
#include "clouds.h"
#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <cstring>
#include <thread>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

template <class Rows>
bool areSameBits(const Rows& a, const Rows& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}

void expectSameSight(Simulation& seen, Simulation& viewer, const std::string& where) {
  EXPECT_EQ(viewer.stateHash(), seen.stateHash()) << where;
  EXPECT_EQ(viewer.stepCount(), seen.stepCount()) << where;
  const simulation::Surface &a = viewer.surface(true), &b = seen.surface(true);
  EXPECT_TRUE(areSameBits(a.positions, b.positions)) << where;
  EXPECT_TRUE(areSameBits(a.normals, b.normals)) << where;
  EXPECT_TRUE(areSameBits(a.displacement, b.displacement)) << where;
  EXPECT_TRUE(areSameBits(a.error, b.error)) << where;
  EXPECT_EQ(a.source, b.source) << where;
  EXPECT_EQ(stretchLinksOf(viewer.model()), stretchLinksOf(seen.model())) << where;
  EXPECT_EQ(viewer.pinned(), seen.pinned()) << where;
  EXPECT_EQ(viewer.isAsleep(), seen.isAsleep()) << where;
  for (Index i = 0; i < seen.state().size(); ++i) EXPECT_EQ(viewer.isAwake(i), seen.isAwake(i)) << where;
  EXPECT_EQ(viewer.activeForces(), seen.activeForces()) << where;
  const std::vector<simulation::ToolReaction> felt = viewer.toolReactions(), expected = seen.toolReactions();
  ASSERT_EQ(felt.size(), expected.size()) << where;
  for (std::size_t t = 0; t < felt.size(); ++t) EXPECT_EQ(felt[t].force, expected[t].force) << where;
  const simulation::Statistics told = viewer.statistics(), known = seen.statistics();
  EXPECT_EQ(told.elastic_energy, known.elastic_energy) << where;
  EXPECT_EQ(told.potential_energy, known.potential_energy) << where;
  EXPECT_TRUE(areSameBits(std::vector<double>{told.error_estimate}, std::vector<double>{known.error_estimate})) << where;
  EXPECT_EQ(told.substeps, known.substeps) << where;
  EXPECT_EQ(told.time_total, known.time_total) << where;
  EXPECT_EQ(told.links, known.links) << where;
  EXPECT_EQ(told.awake, known.awake) << where;
  EXPECT_EQ(told.skipped, known.skipped) << where;
}

tool::ToolParams makeTool(const char* id, tool::Mode mode) {
  tool::ToolParams tool;
  tool.id = id;
  tool.mode = mode;
  return tool;
}

/// A sheet with all kinds of interaction: a ball that presses, a knife, a force.
SceneParams busySheet() {
  SceneParams p = hangingSheet();
  tool::ToolParams ball = makeTool("ball", tool::Mode::kSolid), knife = makeTool("knife", tool::Mode::kCut);
  ball.shape.radius = 0.15;
  ball.path = {{0.0, Vec3(0.6, 0.0, 0.1)}, {0.2, Vec3(0.6, 0.0, -0.1)}};
  knife.shape.kind = geometry::Solid::Kind::kBox;
  knife.shape.size = Vec3(0.002, 0.1, 0.4);
  knife.path = {{0.1, Vec3(0.813, -0.7, 0.0)}, {0.2, Vec3(0.813, 0.7, 0.0)}};
  p.tools = {ball, knife};
  simulation::ForceParams pull;
  pull.id = "pull";
  pull.point = Vec3(0.5, 0.3, 0.0);
  pull.force = Vec3(0.0, 0.0, 0.5);
  pull.radius = 0.1;
  pull.start = 0.05;
  p.forces = {pull};
  return p;
}

TEST(Viewer, ShowsASheetThatIsPressedPulledAndCut) {
  Simulation s(busySheet(), sheetCloud());
  Simulation viewer = s.viewer();
  expectSameSight(s, viewer, "at rest");
  for (int k = 0; k < 30; ++k) {
    run(s, 1);
    if (k % 3 != 0) continue;  // a viewer may skip steps
    viewer.restore(s.sight());
    expectSameSight(s, viewer, "step " + std::to_string(k));
  }
  EXPECT_LT(stretchLinksOf(s.model()).size(), stretchLinksOf(Simulation(hangingSheet(), sheetCloud()).model()).size());
  s.reset();
  viewer.restore(s.sight());
  expectSameSight(s, viewer, "after a reset");
}

TEST(Viewer, ShowsPointsThatWereInserted) {
  Simulation s(resampledSheet(), sheetCloud());
  Simulation viewer = s.viewer();
  for (int k = 0; k < 6; ++k) {
    run(s, 10);
    viewer.restore(s.sight());
    expectSameSight(s, viewer, "step " + std::to_string(s.stepCount()));
  }
  EXPECT_FALSE(s.surface(true).source.empty());
}

TEST(Viewer, ShowsParticlesThatGo) {
  SceneParams p;
  p.model = "oriented_particles";
  p.gravity.setZero();
  p.simplification.target_points = 150;
  tool::ToolParams eraser = makeTool("eraser", tool::Mode::kErase);
  eraser.shape.radius = 0.1;
  eraser.path = {{0.0, Vec3(0.2, 0.0, 0.0)}, {0.1, Vec3(0.8, 0.0, 0.0)}};
  p.tools = {eraser};
  Simulation s(p, sheetCloud());
  Simulation viewer = s.viewer();
  const Index before = s.state().size();
  for (int k = 0; k < 10; ++k) {
    run(s, 1);
    viewer.restore(s.sight());
    expectSameSight(s, viewer, "step " + std::to_string(k));
  }
  EXPECT_LT(s.state().size(), before);
}

TEST(Viewer, ShowsWhichPartsSleep) {
  SceneParams p = hangingSheet();
  p.gravity.setZero();
  simulation::ForceParams pull;
  pull.id = "pull";
  pull.point = Vec3(0.95, 0.0, 0.0);
  pull.force = Vec3(0.0, 0.0, 1e-4);
  pull.start = 0.5;
  p.forces = {pull};
  Simulation s(p, sheetCloud());
  Simulation viewer = s.viewer();
  bool was_asleep = false;
  for (int k = 0; k < 70; ++k) {
    run(s, 1);
    viewer.restore(s.sight());
    expectSameSight(s, viewer, "step " + std::to_string(k));
    was_asleep = was_asleep || s.isAsleep();
  }
  EXPECT_TRUE(was_asleep);
  EXPECT_FALSE(s.isAsleep());
}

TEST(Viewer, LooksFromAThreadOfItsOwnWhileTheSimulationGoesOn) {
  Simulation s(busySheet(), sheetCloud());
  Simulation viewer = s.viewer(), reference(busySheet(), sheetCloud());
  for (int k = 0; k < 10; ++k) {
    run(s, 2);
    const simulation::Snapshot sight = s.sight();
    const std::uint64_t hash = s.stateHash();
    std::thread looker([&] {
      viewer.restore(sight);
      viewer.surface(true);
      EXPECT_EQ(viewer.statistics().state_hash, hash);
    });
    run(s, 1);
    looker.join();
  }
  run(reference, 30);
  EXPECT_EQ(s.stateHash(), reference.stateHash());
}

TEST(Viewer, TakesNoStepsAndASightIsNoSnapshot) {
  Simulation s(hangingSheet(), sheetCloud());
  Simulation viewer = s.viewer();
  const std::uint64_t hash = viewer.stateHash();
  EXPECT_FALSE(viewer.step().ok);
  EXPECT_EQ(viewer.stateHash(), hash);
  EXPECT_THROW(s.restore(s.sight()), InputError);
}

}  // namespace
}  // namespace deformable_surface::test
