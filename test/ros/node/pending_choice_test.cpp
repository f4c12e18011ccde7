// That the surface made in the background is the one that trials choose, and that they end when nobody wants them any more.
#include "../../../src/ros/node/pending_choice.h"

#include "simulation/sagging_strip.h"

#include <gtest/gtest.h>

namespace deformable_surface::node {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

bool never() { return false; }
constexpr double kLong = 600.0;  // s

SceneParams withTarget() {
  SceneParams p = test::saggingStrip(solve::IntegratorType::kVerlet);
  p.accuracy.position_error = 0.1;
  return p;
}

TEST(PendingChoice, IsTheSurfaceThatTrialsChoose) {
  std::atomic<int> calls{0};
  PendingChoice choosing(withTarget(), test::strip(), 1, [&] { ++calls; });
  ASSERT_TRUE(choosing.wait(kLong, never));
  EXPECT_TRUE(choosing.isMade());
  PendingChoice::Made made = choosing.take();
  ASSERT_EQ(made.problem, "");
  Simulation direct(withTarget(), test::strip());
  EXPECT_TRUE(made.simulation->accuracyChoice().is_met);
  EXPECT_EQ(made.simulation->accuracyChoice().sentence, direct.accuracyChoice().sentence);
  ASSERT_TRUE(made.simulation->step().ok);
  ASSERT_TRUE(direct.step().ok);
  EXPECT_EQ(made.simulation->stateHash(), direct.stateHash());
  made.viewer->restore(made.simulation->sight());
  EXPECT_FALSE(made.viewer->step().ok);
}

TEST(PendingChoice, EndsItsTrialsWhenItGoes) {
  SceneParams p = withTarget();
  p.accuracy.position_error = 10.0;  // met as long as the trial runs, for seconds
  p.duration = 1e6;
  std::string problem;
  PendingChoice* made = nullptr;
  {
    PendingChoice choosing(p, test::strip(), 1, [&] { problem = made->take().problem; });
    made = &choosing;
    EXPECT_FALSE(choosing.wait(0.3, never));
    EXPECT_FALSE(choosing.wait(kLong, [] { return true; }));
    EXPECT_FALSE(choosing.isMade());
  }
  EXPECT_EQ(problem, "was interrupted");
}

TEST(PendingChoice, FindsOnlyWhatMeetsTheTargetOrStaysBelowItWithoutABound) {
  simulation::AccuracyChoice choice;
  choice.points = 800;
  choice.candidates.resize(2);
  choice.candidates[0].points = 128;
  choice.candidates[0].error = 3e-3;
  choice.candidates[1].points = 800;
  choice.candidates[1].error = 5e-4;
  EXPECT_FALSE(isFound(choice, 1e-3));  // its trial was ended early
  EXPECT_FALSE(isFound(choice, 1e-4));
  choice.candidates[1].is_bounded = false;
  EXPECT_TRUE(isFound(choice, 1e-3));
  EXPECT_FALSE(isFound(choice, 1e-4));
  choice.points = 8000;
  EXPECT_FALSE(isFound(choice, 1e-3));
  choice.is_met = true;
  EXPECT_TRUE(isFound(choice, 1e-3));
}

TEST(PendingChoice, SaysWhatWasTriedAndWhatAllPointsCost) {
  simulation::AccuracyChoice choice;
  choice.points = 12800;
  choice.work = 1e6;
  choice.candidates.resize(1);
  choice.candidates[0].points = 128;
  choice.candidates[0].error = 3e-3;
  choice.candidates[0].work = 1e3;  // grows with points^1.5
  const std::string begin =
      "trials found no number of points that is known to meet accuracy.position_error; the surface has its 1000 points, after "
      "~reset, too; without accuracy.position_error, simplification.method: none simulates all";
  EXPECT_EQ(sayNotFound(choice, 1e-3, 1000, 4000), begin +
                                                       ", which is expected to take 8 times the work; errors expected in the "
                                                       "trials, by points: 128: 0.003 m");
  choice.points = 128;
  choice.candidates[0].error = 1e-4;
  EXPECT_EQ(sayNotFound(choice, 1e-3, 1000, 4000), begin + "; errors expected in the trials, by points: 128: not known");
  EXPECT_EQ(sayNotFound(choice, 1e-3, 100, 100).find("simplification"), std::string::npos);
}

TEST(PendingChoice, TellsWhyThereIsNone) {
  SceneParams p = withTarget();
  p.pins.emplace_back();
  p.pins.back().region.min = p.pins.back().region.max = Vec3::Constant(1e3);
  PendingChoice choosing(p, test::strip(), 1, [] {});
  ASSERT_TRUE(choosing.wait(kLong, never));
  const PendingChoice::Made made = choosing.take();
  EXPECT_FALSE(made.simulation);
  EXPECT_NE(made.problem.find("pins"), std::string::npos) << made.problem;
}

}  // namespace
}  // namespace deformable_surface::node
