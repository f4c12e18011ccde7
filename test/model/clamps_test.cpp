// Held patches: the free surface beside them bends like a clamped plate, and the rest of the model does not change.
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "model_checks.h"

namespace deformable_surface::test {
namespace {

using model::MassSpring;

constexpr double kLength = 1.0, kWidth = 0.4, kSpacing = 0.1;

Surface makeStrip(double jitter) { return makeSheet(11, 5, kLength, kWidth, jitter); }

MassSpring makeModel(const Surface& s) {
  model::MaterialParams material;
  material.bending_rigidity = 2.0;
  material.young_modulus = 1e3;
  return MassSpring(s.points, s.normals, s.rings, s.area, s.isClosed(), material, {});
}

std::vector<char> holdBefore(const Surface& s, double edge) {
  std::vector<char> held;
  for (const Vec3& p : s.points) held.push_back(p.x() < edge + 1e-9);
  return held;
}

bool hold(MassSpring& strip, const Surface& s, const std::vector<char>& held) {
  return strip.setHeld(held, edgesAtPoints(s, held));
}

// The bending energy only: the membrane energy is subtracted.
double bendingEnergy(const MassSpring& strip, const Surface& s, const Points& bent) {
  model::MaterialParams material;
  material.bending_rigidity = 0.0;
  material.young_modulus = 1e3;
  const MassSpring membrane(s.points, s.normals, s.rings, s.area, s.isClosed(), material, {});
  return strip.elasticEnergy(stateAt(bent)) - membrane.elasticEnergy(stateAt(bent));
}

TEST(Clamps, AParabolaBesideAHeldPatchCostsWhatThePlateDoes) {
  const Surface s = makeStrip(0.0);
  const double edge = 3.0 * kSpacing, curvature = 1e-3;
  Points bent = s.points;
  for (Vec3& p : bent)
    if (p.x() > edge) p.z() = 0.5 * curvature * (p.x() - edge) * (p.x() - edge);
  MassSpring strip = makeModel(s);
  const double exact = 0.5 * 2.0 * curvature * curvature * (kLength - edge) * kWidth;
  // Without the clamp the fits across the edge see half the curvature.
  EXPECT_LT(bendingEnergy(strip, s, bent), 0.97 * exact);
  EXPECT_TRUE(hold(strip, s, holdBefore(s, edge)));
  // The fits at the edge have the patch on one side only, which reduces their curvature a little.
  EXPECT_NEAR(bendingEnergy(strip, s, bent) / exact, 1.0, 0.01);
}

TEST(Clamps, AHeldLineOrPointIsAHinge) {
  const Surface s = makeStrip(0.1);
  const Points bent = perturb(s.points, 0.02);
  MassSpring strip = makeModel(s);
  const double before = strip.elasticEnergy(stateAt(bent));
  hold(strip, s, holdBefore(s, 0.0));
  EXPECT_EQ(strip.elasticEnergy(stateAt(bent)), before);
  std::vector<char> one(s.points.size(), 0);
  one[27] = 1;
  hold(strip, s, one);
  EXPECT_EQ(strip.elasticEnergy(stateAt(bent)), before);
}

TEST(Clamps, LettingGoBringsTheUnheldModelBack) {
  const Surface s = makeStrip(0.1);
  const Points bent = perturb(s.points, 0.02);
  MassSpring strip = makeModel(s);
  const double before = strip.elasticEnergy(stateAt(bent));
  EXPECT_TRUE(hold(strip, s, holdBefore(s, 3.0 * kSpacing)));
  EXPECT_NE(strip.elasticEnergy(stateAt(bent)), before);
  EXPECT_FALSE(hold(strip, s, holdBefore(s, 3.0 * kSpacing)));
  EXPECT_TRUE(hold(strip, s, std::vector<char>(s.points.size(), 0)));
  EXPECT_EQ(strip.elasticEnergy(stateAt(bent)), before);
}

TEST(Clamps, TheClampedModelDoesWhatEveryModelMust) {
  const Surface s = makeStrip(0.2);
  MassSpring strip = makeModel(s);
  hold(strip, s, holdBefore(s, 3.0 * kSpacing));
  const Points deformed = perturb(s.points, 0.2 * kSpacing);
  checkRestIsAtRest(strip, s.points, 1.0);
  checkMomentumIsKept(strip, stateAt(deformed));
  checkRigidMotionIsNotNoticed(strip, deformed);
  checkForcesAreMinusTheGradient(strip, deformed, kSpacing);
  checkStiffnessIsTheDerivative(strip, s.points, kSpacing);
  checkStiffnessIsPositive(strip, deformed);
  checkRowBoundsHold(strip, s.points);
}

}  // namespace
}  // namespace deformable_surface::test
