// Permanent deformation of an elastic solid: where flow begins and ends, and what it conserves.
#include "model_checks.h"
#include "solids.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using model::ElasticSolid;

constexpr double kYield = 2000.0;  // Pa: with E = 1e5 Pa at a strain of some two per cent

SolidOptions makePlastic() {
  SolidOptions options;
  options.params.plasticity.yield_stress = kYield;
  options.params.plasticity.max_strain = 10.0;
  return options;
}

Points mapBy(const Mat3& F, const Points& rest) {
  Points points;
  for (const Vec3& p : rest) points.push_back(F * p);
  return points;
}

State beginAt(ElasticSolid& solid, const Points& rest, const Points& positions) {
  State state = stateAt(rest);
  solid.beginAtRest(state);
  state.positions = positions;
  return state;
}

double meanStress(const ElasticSolid& solid, const State& state) {
  std::vector<double> stress;
  solid.computePointStress(state, stress);
  double sum = 0.0;
  for (const double s : stress) sum += s;
  return sum / static_cast<double>(stress.size());
}

Mat3 stretchAlongX(double stretch, double across) { return Vec3(stretch, across, across).asDiagonal(); }

TEST(PlasticFlow, IsNoneBelowTheYield) {
  const Points rest = makeBox(5, 4, 4, 0.1, 0.2);
  ElasticSolid solid = makeSolid(rest, makePlastic());
  State state = beginAt(solid, rest, mapBy(stretchAlongX(1.01, 0.997), rest));
  ASSERT_LT(meanStress(solid, state), kYield);
  const double energy = solid.elasticEnergy(state);
  EXPECT_FALSE(solid.flow(0.01, state));
  EXPECT_EQ(state.dissipated, 0.0);
  EXPECT_EQ(solid.elasticEnergy(state), energy);
  for (const Mat3& plastic : state.plastic) EXPECT_EQ(plastic, Mat3::Identity());
}

// Uniform strain, so that all points flow alike: to the yield, without a change of volume, and by the dissipated energy.
TEST(PlasticFlow, TakesWhatIsBeyondTheYieldAndTellsTheEnergy) {
  const Points rest = makeBox(5, 4, 4, 0.1, 0.2);
  ElasticSolid solid = makeSolid(rest, makePlastic());
  State state = beginAt(solid, rest, mapBy(stretchAlongX(1.1, 0.97), rest));
  ASSERT_GT(meanStress(solid, state), 3.0 * kYield);
  const double energy = solid.elasticEnergy(state);
  EXPECT_TRUE(solid.flow(0.01, state));
  // The logarithm of a strain of four per cent differs from the strain by a fiftieth. Two thirds of it flow.
  solid.flow(0.01, state);
  EXPECT_NEAR(meanStress(solid, state), kYield, 0.05 * kYield);
  for (const Mat3& plastic : state.plastic) EXPECT_NEAR(plastic.determinant(), 1.0, 1e-12);
  EXPECT_NEAR(energy - solid.elasticEnergy(state), state.dissipated, 1e-10 * energy);
  EXPECT_GT(state.dissipated, 0.5 * energy * (1.0 - 1.0 / 3.0));
}

TEST(PlasticFlow, LeavesForcesMinusTheGradientOfTheEnergyAndMomentumAsItIs) {
  const Points rest = makeBox(4, 4, 4, 0.1, 0.2);
  ElasticSolid solid = makeSolid(rest, makePlastic());
  State state = beginAt(solid, rest, perturb(mapBy(stretchAlongX(1.1, 0.97), rest), 0.005));
  ASSERT_TRUE(solid.flow(0.01, state));
  checkMomentumIsKept(solid, state);
  const Points forces = forcesAt(solid, state);
  const double step = 1e-6, largest_force = largest(forces);
  for (const Index i : {0, 13, 30, 63})
    for (int axis = 0; axis < 3; ++axis) {
      State ahead = state, behind = state;
      ahead.positions[i][axis] += step;
      behind.positions[i][axis] -= step;
      const double slope = (solid.elasticEnergy(ahead) - solid.elasticEnergy(behind)) / (2.0 * step);
      EXPECT_NEAR(forces[i][axis], -slope, 1e-6 * largest_force) << i;
    }
}

TEST(PlasticFlow, DoesNotNoticeRotations) {
  const Points rest = makeBox(4, 4, 4, 0.1, 0.2);
  const Mat3 turn = Eigen::AngleAxisd(1.0, Vec3(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  const Mat3 F = stretchAlongX(1.1, 0.97);
  ElasticSolid straight = makeSolid(rest, makePlastic()), turned = makeSolid(rest, makePlastic());
  State a = beginAt(straight, rest, mapBy(F, rest)), b = beginAt(turned, rest, mapBy(turn * F, rest));
  EXPECT_TRUE(straight.flow(0.01, a));
  EXPECT_TRUE(turned.flow(0.01, b));
  for (std::size_t i = 0; i < a.plastic.size(); ++i) EXPECT_LT((a.plastic[i] - b.plastic[i]).norm(), 1e-10);
}

// The part beyond the yield decays by exp(-creep t), whatever the steps.
TEST(PlasticFlow, CreepsByTimeAndNotBySteps) {
  const Points rest = makeBox(4, 4, 4, 0.1);
  SolidOptions options = makePlastic();
  options.params.plasticity.creep = OrAuto<double>(5.0);
  double beyond[2];
  for (const int steps : {1, 20}) {
    ElasticSolid solid = makeSolid(rest, options);
    State state = beginAt(solid, rest, mapBy(stretchAlongX(1.05, 0.985), rest));
    const double before = meanStress(solid, state) - kYield;
    for (int k = 0; k < steps; ++k) solid.flow(0.1 / steps, state);
    beyond[steps > 1] = (meanStress(solid, state) - kYield) / before;
  }
  // The logarithm of stretches of some per cent differs from them by as much.
  EXPECT_NEAR(beyond[0], std::exp(-0.5), 0.03);
  EXPECT_NEAR(beyond[1], beyond[0], 0.01);
}

TEST(PlasticFlow, EndsAtTheLargestStrain) {
  const Points rest = makeBox(4, 4, 4, 0.1);
  SolidOptions options = makePlastic();
  options.params.plasticity.max_strain = 0.02;
  ElasticSolid solid = makeSolid(rest, options);
  State state = beginAt(solid, rest, mapBy(stretchAlongX(1.2, 0.94), rest));
  for (int k = 0; k < 5; ++k) solid.flow(0.01, state);
  for (const Mat3& plastic : state.plastic) {
    const Vec3 stretch = plastic.jacobiSvd().singularValues();
    EXPECT_NEAR(std::sqrt(2.0 / 3.0) * stretch.array().log().matrix().norm(), 0.02, 1e-10);
  }
  EXPECT_GT(meanStress(solid, state), 3.0 * kYield);
  EXPECT_FALSE(solid.flow(0.01, state));  // damping, to come to rest
}

TEST(PlasticFlow, IsKnownToNormalsAndToTheStableStep) {
  const Points rest = makeBox(4, 4, 4, 0.1, 0.2);
  ElasticSolid solid = makeSolid(rest, makePlastic());
  Mat3 sheared = Mat3::Identity();
  sheared(0, 1) = 0.5;
  State state = beginAt(solid, rest, mapBy(sheared, rest));
  const double stable = solid.findStableStep(state);
  // All of it has flowed: no stress remains.
  state.plastic.assign(rest.size(), sheared.inverse());
  solid.adopt(state);
  ASSERT_LT(meanStress(solid, state), 1e-6 * kYield);
  std::vector<Eigen::Vector3f> normals;
  solid.turnNormals(state, Points(rest.size(), Vec3::UnitX()), normals);
  const Vec3 expected = Vec3(1.0, -0.5, 0.0).normalized();
  for (const Eigen::Vector3f& normal : normals) EXPECT_LT((normal.cast<double>() - expected).norm(), 1e-6);
  EXPECT_NEAR(solid.findStableStep(state), stable / sheared.inverse().jacobiSvd().singularValues()[0], 1e-9 * stable);
}

TEST(PlasticFlow, OfAPlanarSolidStaysInItsPlane) {
  const Points rest = makeBox(8, 6, 1, 0.1, 0.2);
  ElasticSolid solid = makePlanarSolid(rest, makePlastic());
  State state = beginAt(solid, rest, mapBy(stretchAlongX(1.1, 0.97), rest));
  EXPECT_TRUE(solid.flow(0.01, state));
  solid.flow(0.01, state);
  for (const Mat3& plastic : state.plastic) {
    EXPECT_NEAR(plastic.determinant(), 1.0, 1e-12);
    EXPECT_LT((plastic * Vec3::UnitZ() - Vec3::UnitZ()).norm(), 1e-14);
  }
}

// Without plasticity none of this happens.
TEST(PlasticFlow, OffTakesNoMemory) {
  const Points rest = makeBox(4, 4, 4, 0.1);
  ElasticSolid solid = makeSolid(rest);
  State state = beginAt(solid, rest, mapBy(stretchAlongX(1.5, 1.0), rest));
  EXPECT_FALSE(solid.flow(0.01, state));
  EXPECT_TRUE(state.plastic.empty());
}

}  // namespace
}  // namespace deformable_surface::test
