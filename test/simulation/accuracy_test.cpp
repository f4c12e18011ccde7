// A surface is built with what the accuracy of its scene chooses, or with what the scene states.
#include "../../src/simulation/accuracy.h"

#include "sagging_strip.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::Simulation;
using solve::IntegratorType;

TEST(AccuracyChoice, WithoutATargetIsAThousandPoints) {
  const Simulation s(saggingStrip(IntegratorType::kVerlet), sheetCloud(40));
  EXPECT_FALSE(s.accuracyChoice().is_asked);
  EXPECT_EQ(s.accuracyChoice().sentence, "");
  EXPECT_EQ(s.state().size(), 1000);
}

TEST(AccuracyChoice, IsTheSameForASurfaceThatWasPrepared) {
  simulation::SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.accuracy.position_error = 0.1;
  simulation::AccuracyChoice of_cloud, of_prepared;
  const simulation::RestSurface built = simulation::buildChosen(p, strip(), of_cloud);
  simulation::RestSurface prepared = simulation::prepareSurface(p, strip(), simulation::findCoarsest(p), true);
  const simulation::RestSurface shared = simulation::buildChosen(p, std::move(prepared), of_prepared);
  EXPECT_LT(built.points.size(), built.dense.positions.size());
  EXPECT_EQ(of_cloud.sentence, of_prepared.sentence);
  EXPECT_EQ(built.dense_index, shared.dense_index);
  EXPECT_EQ(built.notes.back(), of_cloud.sentence);
}

TEST(AccuracyChoice, UntriedIsAThousandPointsWithTheTargetOfWhichNothingIsKnown) {
  simulation::SceneParams p = saggingStrip(IntegratorType::kVerlet), free = p;
  p.accuracy.position_error = 1e-3;
  Simulation s = Simulation::untried(p, sheetCloud(40)), of_scene_without(free, sheetCloud(40));
  const simulation::AccuracyChoice& choice = s.accuracyChoice();
  EXPECT_TRUE(choice.is_asked);
  EXPECT_FALSE(choice.is_met);
  EXPECT_TRUE(choice.candidates.empty());
  EXPECT_EQ(choice.points, 1000);
  EXPECT_EQ(
      choice.sentence,
      "accuracy.position_error 0.001 m: begins with 1000 of 1600 points, as many as without a target; whether they meet it is "
      "not known");
  EXPECT_EQ(s.buildNotes().back(), choice.sentence);
  EXPECT_EQ(s.params().accuracy.position_error, 1e-3);
  EXPECT_EQ(s.state().size(), 1000);
  ASSERT_TRUE(s.step().ok);
  ASSERT_TRUE(of_scene_without.step().ok);
  EXPECT_EQ(s.statistics().simulation_time, of_scene_without.statistics().simulation_time);
  EXPECT_EQ(Simulation::untried(p, sheetCloud(10)).state().size(), 100);
}

}  // namespace
}  // namespace deformable_surface::test
