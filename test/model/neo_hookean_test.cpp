// The neo-Hookean law of elastic solids against closed forms and against its own second derivative.
#include "../../src/model/elastic_solid/neo_hookean.h"

#include "model_checks.h"
#include "solids.h"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

namespace deformable_surface::test {
namespace {

using model::ElasticSolid;
namespace law = model::neo_hookean;

constexpr double kMu = 2.0, kSpacing = 0.1;

SolidOptions neoHookean() {
  SolidOptions options;
  options.params.law = model::SolidLaw::kNeoHookean;
  return options;
}

// The derivative of the stress at F by central differences, (9 x 9).
Eigen::MatrixXd differentiateStress(double lambda, const Mat3& F) {
  constexpr double h = 1e-5;
  Eigen::MatrixXd H(9, 9);
  for (int k = 0; k < 9; ++k) {
    Mat3 ahead = F, behind = F;
    ahead(k / 3, k % 3) += h;
    behind(k / 3, k % 3) -= h;
    const Mat3 change = (law::findStress(kMu, lambda, ahead) - law::findStress(kMu, lambda, behind)) / (2.0 * h);
    for (int l = 0; l < 9; ++l) H(l, k) = change(l / 3, l % 3);
  }
  return H;
}

// The same with another factor of the second derivative of J.
Eigen::MatrixXd replaceFactor(double lambda, const Mat3& F, const law::Factor& s) {
  const law::Factor factor = law::findFactor(kMu, lambda, F.determinant());
  Mat3 g;
  g << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  Eigen::VectorXd row(9);
  for (int k = 0; k < 9; ++k) row[k] = g(k / 3, k % 3);
  const Eigen::MatrixXd pressed = row * row.transpose(), without = kMu * Eigen::MatrixXd::Identity(9, 9);
  const Eigen::MatrixXd second = (differentiateStress(lambda, F) - without - factor.slope * pressed) / factor.value;
  return without + s.slope * pressed + s.value * second;
}

double lowestOf(const Eigen::MatrixXd& H) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H, Eigen::EigenvaluesOnly).eigenvalues().minCoeff();
}
double highestOf(const Eigen::MatrixXd& H) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

std::vector<Mat3> someGradients() {
  std::mt19937 generator(8);
  std::vector<Mat3> gradients = {Mat3(Vec3(0.6, 0.6, 0.6).asDiagonal()), Mat3(Vec3(1.6, 1.5, 1.4).asDiagonal()),
                                 Mat3(Vec3(1.0, 1.0, -1.0).asDiagonal())};
  for (int k = 0; k < 60; ++k) {
    const double size = 0.1 + 0.03 * k;
    Mat3 F = Mat3::Identity();
    for (int c = 0; c < 3; ++c) F.col(c) += size * randomVector(generator);
    gradients.push_back(F);
  }
  return gradients;
}

TEST(NeoHookean, IsPositiveWithALimitedFactorAndKeepsTheFactorWhereItIs) {
  int num_limited = 0, num_kept = 0;
  for (const double lambda : {0.0, 3.0, 18.0, -0.5})
    for (const Mat3& F : someGradients()) {
      const law::Factor s = law::findFactor(kMu, lambda, F.determinant()), limited = law::limitFactor(kMu, F, s);
      const double highest = highestOf(differentiateStress(lambda, F));
      EXPECT_GE(lowestOf(replaceFactor(lambda, F, limited)), -1e-7 * highest) << F;
      EXPECT_GE(s.value * limited.value, 0.0);
      EXPECT_LE(std::abs(limited.value), std::abs(s.value));
      if (lowestOf(differentiateStress(lambda, F)) > 1e-6 * highest && s.slope >= 0.0) {
        EXPECT_EQ(limited.value, s.value) << F;
        ++num_kept;
      }
      num_limited += limited.value != s.value;
    }
  EXPECT_GT(num_limited, 50);
  EXPECT_GT(num_kept, 5);
}

TEST(NeoHookean, BoundsItsStiffness) {
  for (const double lambda : {0.0, 3.0, 18.0}) {
    EXPECT_NEAR(law::boundStiffening(kMu, lambda, Mat3::Identity()), 1.0, 1e-7);
    for (const Mat3& F : someGradients()) {
      const double bound = law::boundStiffening(kMu, lambda, F), highest = highestOf(differentiateStress(lambda, F));
      EXPECT_GE(bound * (2.0 * kMu + 3.0 * lambda), highest * (1.0 - 1e-7)) << F;
      EXPECT_LE(bound, 3.0 * std::max(highest / (2.0 * kMu), 1.0)) << F;
    }
  }
}

// Uniform stretch l of a bar whose sides are free: mu + s l = 0, a quadratic equation for J.
TEST(NeoHookean, ABarIsPulledAsTheClosedFormSays) {
  const Points rest = makeBox(7, 5, 5, kSpacing);  // jittered cells overlap a little at the faces
  const ElasticSolid solid = makeSolid(rest, neoHookean());
  const double E = 1e5, nu = 0.3, mu = E / (2.0 * (1.0 + nu)), lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  for (const double stretch : {0.2, 0.6, 0.9, 1.2, 2.0}) {
    const double b = mu / (lambda * stretch) - 1.0;
    const double J = 0.5 * (std::sqrt(b * b + 4.0 * mu / lambda) - b), across = std::sqrt(J / stretch);
    const double pull = mu * stretch - mu / stretch * across * across;
    Points at = rest;
    for (Vec3& p : at) p = Vec3(stretch * p.x(), across * p.y(), across * p.z());
    const Points forces = forcesAt(solid, stateAt(at));
    double sum = 0.0, rest_of_it = 0.0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const bool is_end = rest[i].x() < 1e-9 || rest[i].x() > 6.0 * kSpacing - 1e-9;
      if (rest[i].x() < 1e-9) sum += forces[i].x();
      rest_of_it = std::max(rest_of_it, is_end ? forces[i].tail<2>().norm() : forces[i].norm());
    }
    const double area = 16.0 * kSpacing * kSpacing;
    EXPECT_NEAR(sum, pull * area, 1e-6 * E * area) << stretch;
    EXPECT_LT(rest_of_it, 1e-6 * E * kSpacing * kSpacing) << stretch;
  }
}

// At a strain so small that the energies of its parts cancel all but their rounding.
TEST(NeoHookean, HasTheEnergyOfLinearElasticityAtSmallStrains) {
  const Points rest = makeBox(7, 5, 5, kSpacing, 0.3);
  const ElasticSolid solid = makeSolid(rest, neoHookean());
  const double E = 1e5, nu = 0.3, mu = E / (2.0 * (1.0 + nu)), lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  const Vec3 strain = 1e-6 * Vec3(1.0, -0.7, 0.4);
  const Mat3 turn = Eigen::AngleAxisd(2.0, Vec3(1.0, 2.0, 2.0).normalized()).toRotationMatrix();
  Points at = rest;
  for (Vec3& p : at) p = turn * (p + strain.cwiseProduct(p));
  const double expected =
      6 * 4 * 4 * std::pow(kSpacing, 3) * (mu * strain.squaredNorm() + 0.5 * lambda * std::pow(strain.sum(), 2));
  EXPECT_NEAR(solid.elasticEnergy(stateAt(at)), expected, 1e-5 * expected);
}

// Stretched, pressed together and sheared: 0.5 to 1 of what the stiffness matrix allows.
TEST(NeoHookean, KnowsAStableStepOfItsState) {
  const Points rest = makeBox(5, 4, 4, kSpacing, 0.3);
  const ElasticSolid solid = makeSolid(rest, neoHookean());
  Mat3 sheared = Mat3::Identity();
  sheared(0, 1) = 0.8;
  for (const Mat3& F : {Mat3(Mat3::Identity()), Mat3(Vec3(1.6, 0.9, 0.9).asDiagonal()), Mat3(Vec3(1.5, 1.5, 1.5).asDiagonal()),
                        Mat3(Vec3(0.6, 1.1, 1.1).asDiagonal()), Mat3(Vec3(0.7, 0.7, 0.7).asDiagonal()), sheared}) {
    Points at = rest;
    for (Vec3& p : at) p = F * p;
    const Index n = static_cast<Index>(at.size());
    solid.prepareStiffness(stateAt(at), model::Hessian::kExact);
    Eigen::MatrixXd K(3 * n, 3 * n);
    for (Index c = 0; c < 3 * n; ++c) {
      Points v(n, Vec3::Zero()), product(n, Vec3::Zero());
      v[c / 3][c % 3] = 1.0 / std::sqrt(solid.masses()[c / 3]);
      solid.addStiffnessProduct(v, product);
      for (Index i = 0; i < n; ++i) K.block<3, 1>(3 * i, c) = product[i] / std::sqrt(solid.masses()[i]);
    }
    const double exact = 2.0 / std::sqrt(highestOf(K)), step = solid.findStableStep(stateAt(at));
    std::printf("stable step over the exact one: %.3f\n", step / exact);
    EXPECT_LT(step, exact) << F;
    EXPECT_GT(step, 0.5 * exact) << F;
  }
}

}  // namespace
}  // namespace deformable_surface::test
