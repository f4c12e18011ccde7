// A model with only the core interface: every question has a default answer.
#include "deformable_surface/model/deformable_model.h"

#include <gtest/gtest.h>

#include "../solve/oscillators.h"

namespace deformable_surface::test {
namespace {

TEST(DeformableModel, WithoutACapabilityHasNothingOfItsKind) {
  Oscillators oscillators({4.0, 9.0}, 0.5);
  const model::DeformableModel& model = oscillators;
  EXPECT_NE(model.stiffnessMatrix(), nullptr);
  EXPECT_EQ(model.stiffnessProducts(), nullptr);
  EXPECT_EQ(model.splitForces(), nullptr);
  EXPECT_EQ(model.partition(), nullptr);
  EXPECT_EQ(oscillators.innerState(), nullptr);
  EXPECT_EQ(oscillators.clamping(), nullptr);
  EXPECT_EQ(oscillators.pointMaterials(), nullptr);
  EXPECT_FALSE(isOriented(model));
  EXPECT_FALSE(isClosed(model));
  EXPECT_TRUE(trianglesOf(model).empty());
  EXPECT_TRUE(stretchLinksOf(model).empty());
  EXPECT_TRUE(bendLinksOf(model).empty());

  State state{{Vec3(1.0, 0.0, 0.0), Vec3(0.0, 2.0, 0.0)}, {Vec3::Zero(), Vec3::Zero()}};
  const State before = state;
  EXPECT_EQ(maxStretchOf(model, state), 0.0);
  std::vector<double> strain{1.0};
  computePointStrain(model, state, strain);
  EXPECT_EQ(strain, (std::vector<double>{0.0, 0.0}));
  Points areas;
  computeAreaVectors(model, state, areas);
  EXPECT_EQ(areas, Points(2, Vec3::Zero()));
  beginAtRest(oscillators, state);
  adopt(oscillators, state);
  EXPECT_EQ(state.positions, before.positions);
  EXPECT_TRUE(state.orientations.empty());
}

TEST(DeformableModel, ACloneGoesItsOwnWay) {
  const Oscillators oscillators({4.0}, 0.5);
  const std::unique_ptr<model::DeformableModel> clone = oscillators.clone();
  Points forces(1, Vec3::Zero());
  clone->addForces({{Vec3(1.0, 0.0, 0.0)}, {Vec3::Zero()}}, forces);
  EXPECT_EQ(forces[0], Vec3(-4.0, 0.0, 0.0));
  EXPECT_EQ(oscillators.evaluations, 0);
}

}  // namespace
}  // namespace deformable_surface::test
