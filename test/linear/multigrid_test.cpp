// Approximate inverses of spring networks: how close they are to the exact inverse, and where they may be used.
#include "deformable_surface/linear/multigrid.h"

#include "deformable_surface/base/parallel.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

#include <random>

namespace deformable_surface::test {
namespace {

struct Springs {
  Index n;
  std::vector<std::pair<Index, Index>> pairs;
  std::vector<double> diagonal, values;
};

// A lattice with springs of different stiffness to the next points along axes and face diagonals, and a weight on every point.
// The points of the first layer are constrained: identity rows.
Springs makeLattice(Index nx, Index ny, Index nz, double weight) {
  Springs s{nx * ny * nz, {}, {}, {}};
  s.diagonal.assign(s.n, weight);
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> stiffness(0.5, 2.0);
  const auto at = [&](Index x, Index y, Index z) { return (x * ny + y) * nz + z; };
  const Index steps[6][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {0, 1, 1}, {1, 0, 1}};
  for (Index x = 0; x < nx; ++x)
    for (Index y = 0; y < ny; ++y)
      for (Index z = 0; z < nz; ++z)
        for (const auto& d : steps) {
          if (x + d[0] >= nx || y + d[1] >= ny || z + d[2] >= nz) continue;
          const Index i = at(x, y, z), j = at(x + d[0], y + d[1], z + d[2]);
          const double k = stiffness(generator);
          s.pairs.emplace_back(i, j);
          s.values.push_back(x > 0 ? -k : 0.0);
          s.diagonal[i] += k;
          s.diagonal[j] += k;
        }
  for (Index i = 0; i < ny * nz; ++i) s.diagonal[i] = 1.0;
  return s;
}

Points makeVectors(Index n, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  Points points(n);
  for (Vec3& p : points) p = Vec3(number(generator), number(generator), number(generator));
  return points;
}

Points applyTo(const Springs& s, const Points& b) {
  Multigrid multigrid;
  multigrid.analyze(s.n, s.pairs);
  multigrid.setValues(s.diagonal, s.values);
  Points x;
  multigrid.apply(b, x);
  return x;
}

// The matrix of the preconditioner, computed from unit vectors, three at a time.
Eigen::MatrixXd formInverse(const Springs& s) {
  Multigrid multigrid;
  multigrid.analyze(s.n, s.pairs);
  multigrid.setValues(s.diagonal, s.values);
  Eigen::MatrixXd inverse(s.n, s.n);
  Points x;
  for (Index i = 0; i < s.n; i += 3) {
    Points b(s.n, Vec3::Zero());
    for (Index c = 0; c < 3 && i + c < s.n; ++c) b[i + c][c] = 1.0;
    multigrid.apply(b, x);
    for (Index c = 0; c < 3 && i + c < s.n; ++c)
      for (Index k = 0; k < s.n; ++k) inverse(k, i + c) = x[k][c];
  }
  return inverse;
}

// Without weights a body that is held at one end is as soft as possible. Sweeps alone find less than a hundredth of its softest
// motion. With aggregates of some ten points on two levels at least a quarter was found. No motion is overestimated so much that
// an iteration would grow.
TEST(Multigrid, IsSymmetricAndWithinAFactorOfTheInverse) {
  for (const double weight : {0.0, 1.0}) {
    const Springs s = makeLattice(16, 6, 6, weight);
    const Eigen::MatrixXd inverse = formInverse(s);
    EXPECT_LT((inverse - inverse.transpose()).cwiseAbs().maxCoeff(), 1e-13 * inverse.cwiseAbs().maxCoeff());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(s.n, s.n);
    for (Index i = 0; i < s.n; ++i) matrix(i, i) = s.diagonal[i];
    for (std::size_t p = 0; p < s.pairs.size(); ++p)
      matrix(s.pairs[p].first, s.pairs[p].second) = matrix(s.pairs[p].second, s.pairs[p].first) = s.values[p];
    const Eigen::MatrixXd root = matrix.llt().matrixL();
    const Eigen::MatrixXd product = root.transpose() * inverse * root;
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (product + product.transpose())).eigenvalues();
    EXPECT_GT(values[0], 0.2) << weight;
    EXPECT_LT(values[s.n - 1], 2.0) << weight;
  }
}

TEST(Multigrid, GivesTheSameBitsForEveryNumberOfThreads) {
  const Springs s = makeLattice(30, 15, 15, 0.1);
  const Points b = makeVectors(s.n, 2);
  setNumThreads(1);
  const Points one = applyTo(s, b);
  setNumThreads(3);
  EXPECT_EQ(applyTo(s, b), one);
  setNumThreads(0);
}

TEST(Multigrid, StoresInProportionToThePoints) {
  std::size_t sizes[2];
  for (const Index side : {16, 32}) {
    const Springs s = makeLattice(side, side, side, 1.0);
    Multigrid multigrid;
    multigrid.analyze(s.n, s.pairs);
    sizes[side > 16] = multigrid.size();
  }
  EXPECT_LT(sizes[1], 1.1 * 8.0 * static_cast<double>(sizes[0]));  // a larger share of them is inside
}

// Single points, and groups of a few: nothing to coarsen.
TEST(Multigrid, ServesPointsThatNothingIsCoupledTo) {
  Springs s = makeLattice(10, 6, 6, 0.5);
  s.n += 3;
  for (const double d : {1e-6, 1.0, 1e6}) s.diagonal.push_back(d);
  const Points x = applyTo(s, Points(s.n, Vec3::Ones()));
  for (Index i = s.n - 3; i < s.n; ++i) EXPECT_NEAR(x[i].x() * s.diagonal[i], 1.0, 0.1) << i;
  Springs few{2, {{0, 1}}, {2.0, 3.0}, {-1.0}};
  const Points y = applyTo(few, {Vec3(1.0, 0.0, 5.0), Vec3(0.0, 1.0, 0.0)});
  EXPECT_NEAR(y[0].x(), 0.6, 1e-15);
  EXPECT_NEAR(y[1].x(), 0.2, 1e-15);
}

}  // namespace
}  // namespace deformable_surface::test
