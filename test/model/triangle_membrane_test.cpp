// One triangle, whose energy, forces and springs in plane stress are known in closed form.
#include "deformable_surface/model/mass_spring/triangle_membrane.h"

#include "../support/dense.h"
#include "../support/surfaces.h"

#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

constexpr double kStiffness = 120.0, kPoisson = 0.25, kArea = 0.5, kWeight = 0.5;                    // E h in N/m
constexpr double kMu = kStiffness / (2.0 * 1.25), kLambda = kStiffness * kPoisson / (1.0 - 0.0625);  // N/m

const Points kRest{Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()};

model::TriangleMembrane makeTriangle() { return {{{{0, 1, 2}, kWeight}}, kRest, kStiffness, kPoisson}; }

model::State at(const Points& positions) { return {positions, Points(positions.size(), Vec3::Zero())}; }

Points forcesOf(const model::TriangleMembrane& membrane, const Points& points) {
  PaddedPoints positions;
  positions.assign(points);
  Points forces(points.size(), Vec3::Zero());
  membrane.addForces(at(points), positions, forces);
  return forces;
}

// Stretched by a along x, then by b along y, then turned.
Points stretch(double a, double b, const Mat3& turn = Mat3::Identity()) {
  Points points = kRest;
  for (Vec3& p : points) p = turn * Vec3(a * p.x(), b * p.y(), 0.0);
  return points;
}

TEST(TriangleMembrane, StoresTheEnergyOfPlaneStressHoweverItIsTurned) {
  const model::TriangleMembrane membrane = makeTriangle();
  EXPECT_NEAR(membrane.energy(at(stretch(1.0, 1.0, someRotation()))), 0.0, 1e-15);
  const double expected = kWeight * kArea * (kMu * (0.01 + 0.04) + 0.5 * kLambda * 0.01);
  EXPECT_NEAR(membrane.energy(at(stretch(1.1, 0.8))), expected, 1e-12);
  EXPECT_NEAR(membrane.energy(at(stretch(1.1, 0.8, someRotation()))), expected, 1e-12);
}

// The stress along x acts on the edges, with half of the force of each edge at either end.
TEST(TriangleMembrane, PullsByItsStressOverTheEdges) {
  const double along = 2.0 * kMu * 0.1 + kLambda * 0.1, across = kLambda * 0.1;  // N/m, by F = diag(1.1, 1)
  const Points forces = forcesOf(makeTriangle(), stretch(1.1, 1.0));
  const double share = kWeight * kArea;
  EXPECT_LT((forces[1] - Vec3(-share * along, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_LT((forces[2] - Vec3(0.0, -share * across, 0.0)).norm(), 1e-12);
  EXPECT_LT((forces[0] + forces[1] + forces[2]).norm(), 1e-12);
}

TEST(TriangleMembrane, ProjectsItsStiffnessToPositiveWhereItIsPressed) {
  const model::TriangleMembrane membrane = makeTriangle();
  for (const bool is_positive : {false, true}) {
    BlockSparse stiffness;
    stiffness.begin(3);
    membrane.addStiffness(at(stretch(0.7, 0.7)), is_positive ? model::Hessian::kPositive : model::Hessian::kExact, stiffness);
    stiffness.finish();
    const Eigen::MatrixXd dense = makeDense(stiffness);
    const double least = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense).eigenvalues()[0];
    EXPECT_EQ(least > -1e-10 * dense.norm(), is_positive) << least;
  }
}

TEST(TriangleMembrane, RecoversFromACollapseIntoALine) {
  Points line = kRest;
  line[2] = Vec3(0.5, 0.0, 0.0);
  const Points forces = forcesOf(makeTriangle(), line);
  for (const Vec3& f : forces) EXPECT_TRUE(f.allFinite());
  EXPECT_GT(forces[2].norm(), 0.0);
}

TEST(TriangleMembrane, LeavesOutTrianglesWithoutArea) {
  const model::TriangleMembrane membrane({{{0, 1, 2}, 1.0}}, {Vec3::Zero(), Vec3::UnitX(), Vec3(2.0, 0.0, 0.0)}, kStiffness,
                                         kPoisson);
  EXPECT_EQ(membrane.energy(at(kRest)), 0.0);
  EXPECT_TRUE(membrane.findEdges().empty());
}

TEST(TriangleMembrane, HasNoSpringsAcrossWithoutTension) {
  const model::TriangleMembrane membrane = makeTriangle();
  EXPECT_EQ(membrane.findEdges(), (std::vector<std::pair<Index, Index>>{{0, 1}, {1, 2}, {0, 2}}));
  std::vector<double> along, across, tense;
  membrane.computeSpringsAlong(along);
  membrane.computeSpringsAcross(at(kRest), across);
  membrane.computeSpringsAcross(at(stretch(1.2, 1.2)), tense);
  ASSERT_EQ(across.size(), 3u);
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(across[k], 0.0, 1e-12);
    sum += tense[k];
  }
  EXPECT_GT(sum, 0.0);
  EXPECT_GT(along[0] + along[1] + along[2], 0.0);
}

}  // namespace
}  // namespace deformable_surface::test
