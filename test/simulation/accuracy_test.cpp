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

}  // namespace
}  // namespace deformable_surface::test
