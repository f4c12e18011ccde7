// A run continued from a snapshot gives the same bits in every step as an uninterrupted run.
#include "../simulation/clouds.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace deformable_surface::test {
namespace {

using simulation::Simulation;
using simulation::Snapshot;
using solve::IntegratorType;

constexpr int kSteps = 6;

simulation::SceneParams sceneFor(IntegratorType type) {
  simulation::SceneParams p = hangingSheet();
  p.integrator.type = type;
  p.material.spring_damping = 1e-4;
  p.pressure = 0.1;
  p.viscous_drag = 0.1;
  p.forces.push_back({"begins later", Vec3(1.0, 0.2, 0.0), Vec3(0.3, 0.0, 0.4), 0.3, 0.04, 0.2});
  return p;
}

void command(Simulation& s) {
  s.setForce({"pull", Vec3(1.0, 0.0, 0.0), Vec3(0.5, 0.0, 0.2), 0.2, 0.0, 0.08});
  s.pin({geometry::Region::Kind::kSphere, {}, {}, Vec3(1.0, 0.5, 0.0), 0.1});
  s.setGravity(Vec3(1.0, 0.0, -5.0));
}

std::vector<std::uint64_t> hashes(Simulation& s, int steps) {
  std::vector<std::uint64_t> list;
  for (int k = 0; k < steps; ++k) {
    run(s, 1);
    list.push_back(s.stateHash());
  }
  return list;
}

void checkContinuation(const simulation::SceneParams& p, Index cloud_side, int threads) {
  setNumThreads(threads);
  Simulation whole(p, sheetCloud(cloud_side));
  run(whole, 2);
  command(whole);
  run(whole, 2);
  const Snapshot snapshot = whole.snapshot();
  const std::vector<std::uint64_t> expected = hashes(whole, kSteps);
  const Points surface = whole.surface(false).positions;

  // In the same simulation, after other steps.
  whole.removeForce("pull");
  whole.setGravity(Vec3(0.0, 30.0, 0.0));
  whole.unpin({geometry::Region::Kind::kSphere, {}, {}, Vec3(0.0, 0.0, 0.0), 0.2});
  run(whole, 3);
  whole.restore(snapshot);
  EXPECT_EQ(whole.stepCount(), 4u);
  EXPECT_EQ(hashes(whole, kSteps), expected);
  EXPECT_EQ(whole.surface(false).positions, surface);

  // In a new simulation with another number of threads.
  setNumThreads(threads == 1 ? 3 : 1);
  Simulation other(p, sheetCloud(cloud_side));
  other.restore(snapshot);
  EXPECT_EQ(hashes(other, kSteps), expected);
  EXPECT_EQ(other.surface(false).positions, surface);
  setNumThreads(0);
}

TEST(Snapshot, ExplicitRunsContinueBitForBitForOneTwoAndThreeThreads) {
  for (int threads : {1, 2, 3}) {
    SCOPED_TRACE(threads);
    simulation::SceneParams p = sceneFor(IntegratorType::kVerlet);
    p.simplification.target_points = 2500;  // several blocks in every parallel loop
    checkContinuation(p, 60, threads);
  }
}

TEST(Snapshot, AutoContinuesBitForBit) { checkContinuation(sceneFor(IntegratorType::kAuto), 30, 1); }

TEST(Snapshot, ImplicitRunsContinueBitForBitForOneTwoAndThreeThreads) {
  for (int threads : {1, 2, 3}) {
    SCOPED_TRACE(threads);
    checkContinuation(sceneFor(IntegratorType::kImplicit), 30, threads);
  }
}

TEST(Snapshot, StaticRunsContinueBitForBitForOneTwoAndThreeThreads) {
  for (int threads : {1, 2, 3}) {
    SCOPED_TRACE(threads);
    checkContinuation(sceneFor(IntegratorType::kStatic), 30, threads);
  }
}

TEST(Snapshot, InsertedPointsComeBack) {
  simulation::SceneParams p = sceneFor(IntegratorType::kAuto);
  p.output.resample = true;
  p.forces.push_back({"stretch", Vec3(1.0, 0.0, 0.0), Vec3(300.0, 0.0, 0.0), 0.3, 0.0, 1e300});
  Simulation s(p, sheetCloud());
  const std::size_t input = s.surface(false).positions.size();
  int steps = 0;
  for (; s.surface(false).positions.size() == input && steps < 60; ++steps) run(s, 1);
  ASSERT_GT(s.surface(false).positions.size(), input) << "nothing was inserted";
  const Snapshot snapshot = s.snapshot();
  const Points then = s.surface(false).positions;
  run(s, 10);
  const Points expected = s.surface(false).positions;
  EXPECT_GT(expected.size(), then.size());
  s.restore(snapshot);
  EXPECT_EQ(s.surface(false).positions, then);
  run(s, 10);
  EXPECT_EQ(s.surface(false).positions, expected);
}

TEST(Snapshot, ThatOfAnotherSurfaceOrSceneIsRefusedAndNothingChanges) {
  Simulation s(hangingSheet(), sheetCloud());
  run(s, 2);
  const std::uint64_t before = s.stateHash();
  simulation::SceneParams stiffer = hangingSheet();
  stiffer.material.young_modulus *= 2.0;
  const Simulation other_cloud(hangingSheet(), sheetCloud(31)), other_scene(stiffer, sheetCloud());
  for (const Snapshot& snapshot : {Snapshot(), other_cloud.snapshot(), other_scene.snapshot()}) {
    EXPECT_THROW(s.restore(snapshot), InputError);
    EXPECT_EQ(s.stateHash(), before);
    EXPECT_EQ(s.stepCount(), 2u);
  }
}

TEST(Snapshot, AStateThatCannotBeIsRefusedAndNothingChanges) {
  Simulation s(hangingSheet(), sheetCloud());
  const std::uint64_t before = s.stateHash();
  const Index pinned = static_cast<Index>(std::find(s.pinned().begin(), s.pinned().end(), 1) - s.pinned().begin());
  const auto changed = [&](const auto& change) {
    model::State state = s.state();
    change(state);
    return state;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const model::State& state :
       {changed([&](model::State& x) { x.positions[3].y() = nan; }), changed([&](model::State& x) { x.velocities[3].z() = nan; }),
        changed([&](model::State& x) { x.positions[3].x() = 1e7; }),
        changed([&](model::State& x) { x.velocities[pinned].x() = 1.0; }),
        changed([&](model::State& x) { x.positions.pop_back(); })}) {
    EXPECT_THROW(s.setState(state), InputError);
    EXPECT_EQ(s.stateHash(), before);
  }
  s.setState(changed([&](model::State& x) { x.positions[3] += Vec3(0.0, 0.0, 0.1); }));
  EXPECT_NE(s.stateHash(), before);
}

}  // namespace
}  // namespace deformable_surface::test
