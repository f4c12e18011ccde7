// The elastic solid as a model: masses, energies and forces of its points, and motions that must cause no force.
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "model_checks.h"
#include "solids.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using model::ElasticSolid;

constexpr double kSpacing = 0.1;

Points mapAll(Points points, const Mat3& map) {
  for (Vec3& p : points) p = map * p;
  return points;
}

// Some strain of a tenth, everywhere the same.
Mat3 someStrain(bool is_planar = false) {
  Mat3 F;
  F << 1.10, 0.08, -0.03, -0.04, 0.93, 0.05, 0.02, -0.06, 1.04;
  if (is_planar) F.row(2) = F.col(2).transpose() = Vec3::UnitZ().transpose();
  return F;
}

constexpr model::SolidLaw kLaws[] = {model::SolidLaw::kCorotated, model::SolidLaw::kLinear, model::SolidLaw::kNeoHookean};

SolidOptions withLaw(model::SolidLaw law) {
  SolidOptions options;
  options.params.law = law;
  if (law == model::SolidLaw::kNeoHookean) options.params.plane = model::PlaneKind::kStrain;
  return options;
}

Points flatten(Points points) {
  for (Vec3& p : points) p.z() = 0.0;
  return points;
}

struct Body {
  Points rest;
  ElasticSolid solid;
};

Body makeBody(bool is_planar, const SolidOptions& options = {}) {
  const Points rest = is_planar ? makeBox(12, 6, 1, kSpacing, 0.3) : makeBox(7, 5, 5, kSpacing, 0.3);
  return {rest, is_planar ? makePlanarSolid(rest, options) : makeSolid(rest, options)};
}

Points deform(const Body& body, bool is_planar) {
  const Points points = perturb(mapAll(body.rest, someStrain(is_planar)), 0.05 * kSpacing);
  return is_planar ? flatten(points) : points;
}

// Derivative of the forces by central differences, (3 n x 3 n).
Eigen::MatrixXd differentiateForces(const ElasticSolid& solid, const Points& at, double step) {
  const Index n = static_cast<Index>(at.size());
  Eigen::MatrixXd K(3 * n, 3 * n);
  for (Index c = 0; c < 3 * n; ++c) {
    Points ahead = at, behind = at;
    ahead[c / 3][c % 3] += step;
    behind[c / 3][c % 3] -= step;
    const Points f = forcesAt(solid, stateAt(ahead)), g = forcesAt(solid, stateAt(behind));
    for (Index i = 0; i < n; ++i) K.block<3, 1>(3 * i, c) = (g[i] - f[i]) / (2.0 * step);
  }
  return K;
}

TEST(ElasticSolid, IsAtRestAtRest) {
  for (const bool is_planar : {false, true})
    for (const model::SolidLaw law : kLaws) {
      const Body body = makeBody(is_planar, withLaw(law));
      checkRestIsAtRest(body.solid, body.rest, 1e5 * kSpacing * kSpacing);
    }
}

TEST(ElasticSolid, KeepsMomentum) {
  for (const bool is_planar : {false, true})
    for (const model::SolidLaw law : {model::SolidLaw::kCorotated, model::SolidLaw::kNeoHookean}) {
      const Body body = makeBody(is_planar, withLaw(law));
      checkMomentumIsKept(body.solid, stateAt(deform(body, is_planar)));
    }
}

TEST(ElasticSolid, DoesNotNoticeRigidMotion) {
  for (const model::SolidLaw law : {model::SolidLaw::kCorotated, model::SolidLaw::kNeoHookean}) {
    const Body body = makeBody(false, withLaw(law));
    checkRigidMotionIsNotNoticed(body.solid, deform(body, false));
  }
}

// Central differences of fourth order: the remaining error is rounding.
void checkForcesAreTheGradient(const model::ElasticSolid& solid, const Points& at, bool is_planar, double h = 1e-3 * kSpacing) {
  const Points forces = forcesAt(solid, stateAt(at));
  std::mt19937 generator(5);
  for (int trial = 0; trial < 4; ++trial) {
    Points direction;
    double expected = 0.0;
    for (const Vec3& f : forces) {
      direction.push_back(randomVector(generator));
      if (is_planar) direction.back().z() = 0.0;
      expected -= f.dot(direction.back());
    }
    const auto energyAt = [&](double t) {
      Points moved = at;
      for (std::size_t i = 0; i < at.size(); ++i) moved[i] += t * direction[i];
      return solid.elasticEnergy(stateAt(moved));
    };
    const double slope = (8.0 * (energyAt(h) - energyAt(-h)) - (energyAt(2.0 * h) - energyAt(-2.0 * h))) / (12.0 * h);
    EXPECT_NEAR(slope, expected, 1e-7 * std::abs(expected)) << is_planar << " trial " << trial;
  }
}

TEST(ElasticSolid, PushesByMinusTheGradientOfItsEnergy) {
  for (const bool is_planar : {false, true})
    for (const model::SolidLaw law : kLaws) {
      const SolidOptions options = withLaw(law);
      const Body body = makeBody(is_planar, options);
      const Points at =
          mapAll(deform(body, is_planar),
                 Eigen::AngleAxisd(0.8, is_planar ? Vec3(Vec3::UnitZ()) : Vec3(Vec3(1, 2, 3).normalized())).toRotationMatrix());
      checkForcesAreTheGradient(body.solid, at, is_planar);
    }
}

// Several blocks of points. Inverted points are computed one by one.
TEST(ElasticSolid, PushesByMinusTheGradientOfItsEnergyAcrossBlocksAndInsideOut) {
  const Points rest = makeBox(12, 8, 7, kSpacing, 0.2);
  ASSERT_GT(static_cast<Index>(rest.size()), 2 * model::PointRooms::kPoints);
  std::mt19937 generator(6);
  for (const double side : {1.0, -1.0})
    for (const model::SolidLaw law : kLaws) {
      const SolidOptions options = withLaw(law);
      const model::ElasticSolid solid = makeSolid(rest, options);
      Points at = mapAll(rest, Mat3(Vec3(1.1 * side, 0.95, 1.03).asDiagonal()));
      for (Vec3& p : at) p += 0.02 * kSpacing * randomVector(generator);
      checkForcesAreTheGradient(solid, at, false, 2e-4 * kSpacing);  // rotations change faster in inverted states
      if (law != model::SolidLaw::kLinear) checkMomentumIsKept(solid, stateAt(at));
    }
}

TEST(ElasticSolid, ForgetsAnEnergyWhoseSumWasInterrupted) {
  const Points rest = makeBox(12, 8, 7, kSpacing, 0.2);  // several blocks, between which an interrupt is seen
  const model::State strained = stateAt(mapAll(rest, someStrain()));
  const double energy = makeSolid(rest).elasticEnergy(strained);
  const ElasticSolid solid = makeSolid(rest);
  EXPECT_LT(solid.elasticEnergy(stateAt(rest)), 1e-3 * energy);
  {
    const std::atomic<bool> flag{true};
    const InterruptScope scope(flag);
    EXPECT_THROW(solid.elasticEnergy(strained), Interrupted);
  }
  EXPECT_EQ(solid.elasticEnergy(strained), energy);
}

// psi = mu |e|^2 + lambda/2 tr^2 e of a symmetric stretch, times the volume; no stabilisation.
TEST(ElasticSolid, HasTheEnergyOfAUniformStrainOnJitteredPoints) {
  for (const bool is_planar : {false, true}) {
    const Body body = makeBody(is_planar);
    const Mat3 stretch = Vec3(1.05, 0.97, is_planar ? 1.0 : 1.02).asDiagonal(), strain = stretch - Mat3::Identity();
    const double E = 1e5, nu = 0.3, mu = E / (2.0 * (1.0 + nu));
    const double lambda = is_planar ? E * nu / (1.0 - nu * nu) : E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    const double volume = is_planar ? 11 * 5 * kSpacing * kSpacing * 0.001 : 6 * 4 * 4 * std::pow(kSpacing, 3);
    const double expected = volume * (mu * strain.squaredNorm() + 0.5 * lambda * strain.trace() * strain.trace());
    const Mat3 R = Eigen::AngleAxisd(2.0, Vec3::UnitZ()).toRotationMatrix();
    EXPECT_NEAR(body.solid.elasticEnergy(stateAt(mapAll(body.rest, R * stretch))), expected,
                1e-7 * expected);  // of cells, see point_volumes_test
  }
}

TEST(ElasticSolid, TakesARotationForStrainOnlyByTheLinearLaw) {
  SolidOptions options;
  const Mat3 R = Eigen::AngleAxisd(30.0 * M_PI / 180.0, Vec3(1, 1, 1).normalized()).toRotationMatrix();
  const Body corotated = makeBody(false, options);
  options.params.law = model::SolidLaw::kLinear;
  const Body linear = makeBody(false, options);
  const double scale = 1e5 * 0.096;  // Young's modulus times the volume
  EXPECT_LT(corotated.solid.elasticEnergy(stateAt(mapAll(corotated.rest, R))), 1e-20 * scale);
  EXPECT_GT(linear.solid.elasticEnergy(stateAt(mapAll(linear.rest, R))), 0.01 * scale);
}

// Six rigid motions, and no other motion of almost zero energy.
TEST(ElasticSolid, HasNoMotionWithoutEnergyButRigidOnes) {
  const Points rest = makeBox(5, 4, 4, kSpacing, 0.2);
  const auto softest = [&](double stabilization) {
    SolidOptions options;
    options.params.stabilization = stabilization;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        differentiateForces(makeSolid(rest, options), rest, 1e-4 * kSpacing), Eigen::EigenvaluesOnly);
    const double largest = solver.eigenvalues().maxCoeff();
    EXPECT_LT(std::abs(solver.eigenvalues()[5]), 1e-7 * largest);
    return solver.eigenvalues()[6] / largest;
  };
  EXPECT_GT(softest(0.05), 1.3 * softest(0.0));
  EXPECT_GT(softest(0.05), 0.01);
  std::printf("softest over stiffest: %.4f, without stabilisation %.4f\n", softest(0.05), softest(0.0));
}

Eigen::MatrixXd collectProducts(const ElasticSolid& solid, const Points& at, model::Hessian hessian) {
  const Index n = static_cast<Index>(at.size());
  Eigen::MatrixXd K(3 * n, 3 * n);
  solid.prepareStiffness(stateAt(at), hessian);
  for (Index c = 0; c < 3 * n; ++c) {
    Points v(n, Vec3::Zero()), product(n, Vec3::Zero());
    v[c / 3][c % 3] = 1.0;
    solid.addStiffnessProduct(v, product);
    for (Index i = 0; i < n; ++i) K.block<3, 1>(3 * i, c) = product[i];
  }
  return K;
}

// Central differences of second order are good for about ten digits here.
TEST(ElasticSolid, MultipliesByTheDerivativeOfItsForces) {
  for (const bool is_planar : {false, true})
    for (const model::SolidLaw law : kLaws) {
      const SolidOptions options = withLaw(law);
      const Points rest = is_planar ? makeBox(7, 5, 1, kSpacing, 0.3) : makeBox(5, 4, 4, kSpacing, 0.3);
      const Body body{rest, is_planar ? makePlanarSolid(rest, options) : makeSolid(rest, options)};
      const Points at = mapAll(deform(body, is_planar), Eigen::AngleAxisd(0.8, Vec3::UnitZ()).toRotationMatrix());
      const Eigen::MatrixXd exact = collectProducts(body.solid, at, model::Hessian::kExact);
      Eigen::MatrixXd expected = differentiateForces(body.solid, at, 1e-4 * kSpacing);
      const double scale = expected.lpNorm<Eigen::Infinity>();
      if (is_planar)  // nothing moves across
        for (Eigen::Index i = 2; i < expected.rows(); i += 3) expected.row(i) = exact.row(i), expected.col(i) = exact.col(i);
      EXPECT_LT((exact - expected).lpNorm<Eigen::Infinity>(), 1e-6 * scale) << is_planar;
      EXPECT_LT((exact - exact.transpose()).lpNorm<Eigen::Infinity>(), 1e-13 * scale);
    }
}

// Also where the body is compressed, flattened or inverted: there the derivative itself is not positive.
TEST(ElasticSolid, MultipliesByAPositiveMatrixWhereItIsAskedFor) {
  const Points rest = makeBox(5, 4, 4, kSpacing, 0.3);
  for (const model::SolidLaw law : {model::SolidLaw::kCorotated, model::SolidLaw::kNeoHookean}) {
    const ElasticSolid solid = makeSolid(rest, withLaw(law));
    const auto lowest = [&](const Vec3& stretch, model::Hessian hessian) {
      const Points at = perturb(mapAll(rest, stretch.asDiagonal()), 0.02 * kSpacing);
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(collectProducts(solid, at, hessian), Eigen::EigenvaluesOnly);
      return solver.eigenvalues().minCoeff() / solver.eigenvalues().maxCoeff();
    };
    EXPECT_LT(lowest(Vec3(0.6, 0.6, 0.6), model::Hessian::kExact), -1e-3);
    for (const Vec3& stretch : {Vec3(0.6, 0.6, 0.6), Vec3(1.0, 1.0, 0.0), Vec3(-0.7, 1.1, 0.9), Vec3(1.3, 0.9, 0.8),
                                Vec3(1.0, 1.0, 1.0), Vec3(1.6, 1.4, 1.5)})
      EXPECT_GT(lowest(stretch, model::Hessian::kPositive), -1e-9) << stretch.transpose();
  }
}

// The quality of the preconditioner: products and springs resist every motion alike, up to a factor.
TEST(ElasticSolid, ItsCouplingsResistMuchAsItDoes) {
  const Points rest = makeBox(6, 5, 5, kSpacing, 0.2);
  const ElasticSolid solid = makeSolid(rest);
  const Index n = static_cast<Index>(rest.size());
  Eigen::MatrixXd springs = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (const auto& coupling : solid.couplings())
    for (int c = 0; c < 3; ++c) {
      const Index i = 3 * coupling.i + c, j = 3 * coupling.j + c;
      springs(i, i) += coupling.stiffness;
      springs(j, j) += coupling.stiffness;
      springs(i, j) -= coupling.stiffness;
      springs(j, i) -= coupling.stiffness;
    }
  // With one end held: no motion is free.
  std::vector<Index> free;
  for (Index i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c)
      if (rest[i].x() > 0.0) free.push_back(3 * i + c);
  const Eigen::MatrixXd K = collectProducts(solid, rest, model::Hessian::kExact);
  const Index m = static_cast<Index>(free.size());
  Eigen::MatrixXd A(m, m), B(m, m);
  for (Index r = 0; r < m; ++r)
    for (Index c = 0; c < m; ++c) {
      A(r, c) = 0.5 * (K(free[r], free[c]) + K(free[c], free[r]));
      B(r, c) = springs(free[r], free[c]);
    }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(A, B, Eigen::EigenvaluesOnly);
  std::printf("products over springs: %.3f to %.3f\n", solver.eigenvalues().minCoeff(), solver.eigenvalues().maxCoeff());
  // With a ratio of a hundred, conjugate gradients gain a digit in at most a dozen products.
  EXPECT_LT(solver.eigenvalues().maxCoeff(), 100.0 * solver.eigenvalues().minCoeff());
  EXPECT_GT(solver.eigenvalues().minCoeff(), 0.0);
}

TEST(ElasticSolid, KnowsAStableStep) {
  for (const bool is_planar : {false, true}) {
    const Points rest = is_planar ? makeBox(8, 6, 1, kSpacing, 0.3) : makeBox(5, 4, 4, kSpacing, 0.3);
    const ElasticSolid solid = is_planar ? makePlanarSolid(rest) : makeSolid(rest);
    Eigen::MatrixXd K = differentiateForces(solid, rest, 1e-4 * kSpacing);
    for (Index i = 0; i < K.rows(); ++i) {
      K.row(i) /= std::sqrt(solid.masses()[i / 3]);
      K.col(i) /= std::sqrt(solid.masses()[i / 3]);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(K, Eigen::EigenvaluesOnly);
    const double largest = 2.0 / std::sqrt(solver.eigenvalues().maxCoeff());
    EXPECT_LT(solid.findStableStep(stateAt(rest)), largest);
    EXPECT_GT(solid.findStableStep(stateAt(rest)), 0.8 * largest);
    std::vector<double> rows(rest.size(), 0.0), damping(rest.size(), 0.0);
    solid.addRowBounds(stateAt(rest), rows, damping);
    double bound = 0.0;
    for (std::size_t i = 0; i < rows.size(); ++i) bound = std::max(bound, rows[i] / solid.masses()[i]);
    EXPECT_GT(bound, solver.eigenvalues().maxCoeff());
  }
}

// Inverted, flattened or crushed to a point: the forces are finite, and minus the gradient wherever there is one.
TEST(ElasticSolid, HasForcesInWhateverStateItIs) {
  for (const model::SolidLaw law : {model::SolidLaw::kCorotated, model::SolidLaw::kNeoHookean}) {
    const Body body = makeBody(false, withLaw(law));
    for (const Vec3& squeeze :
         {Vec3(-0.7, 1.1, 0.9), Vec3(1.0, 1.0, 0.0), Vec3(0.0, 0.0, 0.0), Vec3(-1.2, -0.9, -0.8), Vec3(20.0, 0.01, 1.0)}) {
      const Points at = mapAll(body.rest, squeeze.asDiagonal());
      const Points forces = forcesAt(body.solid, stateAt(at));
      EXPECT_TRUE(std::isfinite(largest(forces))) << squeeze.transpose();
      EXPECT_TRUE(std::isfinite(body.solid.elasticEnergy(stateAt(at))));
    }
    const Points inverted = perturb(mapAll(body.rest, Vec3(-0.7, 1.1, 0.9).asDiagonal()), 0.02 * kSpacing);
    checkForcesAreMinusTheGradient(body.solid, inverted, kSpacing);
    checkMomentumIsKept(body.solid, stateAt(inverted));
  }
}

// A body with a chain of points that sticks out: the points on the chain span no volume.
TEST(ElasticSolid, GivesPointsOfAThinPartNoStrainWhereNeighboursAreMissing) {
  Points rest = makeBox(5, 5, 5, kSpacing, 0.2);
  for (int k = 1; k < 40; ++k) rest.push_back(Vec3(4.0 + k, 2.0, 2.0) * kSpacing);
  for (const model::SolidLaw law : {model::SolidLaw::kCorotated, model::SolidLaw::kNeoHookean}) {
    const ElasticSolid solid = makeSolid(rest, withLaw(law));
    EXPECT_GT(solid.numDeficient(), 0);
    checkRestIsAtRest(solid, rest, 1e5 * kSpacing * kSpacing);
    const Points at = perturb(mapAll(rest, someStrain()), 0.02 * kSpacing);
    checkRigidMotionIsNotNoticed(solid, at);
    checkMomentumIsKept(solid, stateAt(at));
    checkForcesAreMinusTheGradient(solid, at, kSpacing);
  }
}

// A point in front of a face, none of whose points has it among its six nearest.
TEST(ElasticSolid, LinksWhatItsForcesHold) {
  Points rest = makeBox(5, 5, 5, kSpacing);
  rest.push_back(Vec3(2.0, 2.0, 5.5) * kSpacing);
  const ElasticSolid solid = makeSolid(rest);
  Points at = rest;
  at.back().z() += 0.1 * kSpacing;
  EXPECT_GT(forcesAt(solid, stateAt(at)).back().norm(), 1e-3 * 1e5 * kSpacing * kSpacing);
  Index num_links = 0;
  for (const auto& [i, j] : solid.stretchLinks()) num_links += j == 125;
  EXPECT_EQ(num_links, 1);
}

TEST(ElasticSolid, GivesTheSameBitsForEveryNumberOfThreads) {
  const Points rest = makeBox(16, 9, 9, kSpacing, 0.3);  // several blocks, and a last group of four that is not full
  const State state = stateAt(perturb(mapAll(rest, someStrain()), 0.1 * kSpacing));
  for (const model::SolidLaw law : {model::SolidLaw::kCorotated, model::SolidLaw::kNeoHookean}) {
    const ElasticSolid solid = makeSolid(rest, withLaw(law));
    setNumThreads(1);
    const Points one = forcesAt(solid, state);
    const double energy = solid.elasticEnergy(state), step = solid.findStableStep(state);
    for (const int threads : {2, 3}) {
      setNumThreads(threads);
      EXPECT_EQ(forcesAt(solid, state), one);
      EXPECT_EQ(solid.elasticEnergy(state), energy);
      EXPECT_EQ(solid.findStableStep(state), step);
    }
  }
  setNumThreads(0);
}

}  // namespace
}  // namespace deformable_surface::test
