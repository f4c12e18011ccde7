// How many steps were not taken as chosen, as statistics tell it.
#include "pressed_layers.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::Simulation;
using simulation::Statistics;
using Type = solve::IntegratorType;

std::vector<std::uint64_t> listCounts(const Statistics& s) {
  return {s.stopped_steps, s.halted_steps, s.retried_steps, s.fallback_steps};
}
const std::vector<std::uint64_t> kNone{0, 0, 0, 0};

TEST(SimulationStatistics, WhereNothingHappensNoStepIsCounted) {
  simulation::SceneParams p = hangingSheet();
  for (const Type type : {Type::kVerlet, Type::kImplicit, Type::kStatic}) {
    p.integrator.type = type;
    Simulation s(p, sheetCloud());
    run(s, 20);
    EXPECT_EQ(listCounts(s.statistics()), kNone);
  }
}

TEST(SimulationStatistics, StepsThatAreRepeatedAreCounted) {
  Simulation s(pressedByPlates(Type::kVerlet), stackLayers(3));
  std::uint64_t retried = 0;
  for (int k = 0; k < 80; ++k) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
    retried += outcome.was_retried;
    EXPECT_EQ(s.statistics().retried_steps, retried);
    EXPECT_LE(s.statistics().halted_steps, s.statistics().stopped_steps);
  }
}

// A force throws one point of a pinned sheet ten edges far within a sub-step.
TEST(SimulationStatistics, StepsInWhichContactLetsNoPointMoveAreHalted) {
  simulation::SceneParams p = hangingSheet();
  p.contact.self = true;
  simulation::ForceParams force;
  force.id = "hook";
  force.point = sheetCloud().positions.back();
  force.force = Vec3(0.0, 0.0, 1e6);
  p.forces.push_back(force);
  Simulation s(p, sheetCloud());
  const simulation::StepOutcome outcome = s.step();
  ASSERT_TRUE(outcome.ok) << outcome.problem;
  EXPECT_EQ(s.statistics().halted_steps, 1u);
  EXPECT_NE(outcome.notice.find("took all motion"), std::string::npos) << outcome.notice;
}

TEST(SimulationStatistics, CountsBeginAnewWithAResetAndGoOnFromASnapshotInForksAndViewers) {
  Simulation s(pressedByPins(Type::kVerlet), stackLayers(2));
  run(s, 60);
  const std::vector<std::uint64_t> counts = listCounts(s.statistics());
  ASSERT_GT(counts[0], 0u);
  const simulation::Snapshot snapshot = s.snapshot();
  Simulation viewer = s.viewer();
  viewer.restore(s.sight());
  EXPECT_EQ(listCounts(viewer.statistics()), counts);
  run(s, 20);
  const std::vector<std::uint64_t> later = listCounts(s.statistics());
  EXPECT_GT(later[0], counts[0]);
  s.restore(snapshot);
  EXPECT_EQ(listCounts(s.statistics()), counts);
  Simulation fork = s.fork();
  run(fork, 20);
  EXPECT_EQ(listCounts(fork.statistics()), later);
  s.reset();
  EXPECT_EQ(listCounts(s.statistics()), kNone);
}

}  // namespace
}  // namespace deformable_surface::test
