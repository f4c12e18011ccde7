// Factors of matrices with one number a pair, against dense ones.
#include "deformable_surface/linear/scalar_cholesky.h"

#include "deformable_surface/base/interrupt.h"

#include <Eigen/Cholesky>

#include <gtest/gtest.h>

#include <atomic>
#include <random>

namespace deformable_surface::test {
namespace {

struct Matrix {
  std::vector<std::pair<Index, Index>> pairs;
  std::vector<double> diagonal, values;
  Eigen::MatrixXd dense;
};

// Some pairs in any order and direction, and points that are coupled to nothing.
Matrix makeMatrix(Index n, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  Matrix m;
  m.diagonal.assign(n, 1e-3);
  m.dense = Eigen::MatrixXd::Zero(n, n);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < i; ++j) {
      if (generator() % 6 != 0 || i % 9 == 0 || j % 9 == 0) continue;
      m.pairs.push_back(generator() % 2 ? std::make_pair(i, j) : std::make_pair(j, i));
      m.values.push_back(number(generator));
    }
  std::shuffle(m.pairs.begin(), m.pairs.end(), generator);
  for (std::size_t k = 0; k < m.pairs.size(); ++k) {
    const auto& [i, j] = m.pairs[k];
    m.dense(i, j) = m.dense(j, i) = m.values[k];
    m.diagonal[i] += std::abs(m.values[k]);
    m.diagonal[j] += std::abs(m.values[k]);
  }
  for (Index i = 0; i < n; ++i) m.dense(i, i) = m.diagonal[i];
  return m;
}

TEST(ScalarCholesky, SolvesForThreeCoordinatesAtOnceAgainAndAgain) {
  for (const Index n : {1, 2, 30, 80}) {
    Matrix m = makeMatrix(n, 3 + n);
    ScalarCholesky cholesky;
    cholesky.analyze(n, m.pairs);
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    for (int turn = 0; turn < 2; ++turn) {
      ASSERT_TRUE(cholesky.factorize(m.diagonal, m.values));
      Points b(n), x;
      Eigen::MatrixXd right(n, 3);
      for (Index i = 0; i < n; ++i) right.row(i) = b[i] = Vec3(number(generator), number(generator), number(generator));
      cholesky.solve(b, x);
      const Eigen::MatrixXd expected = m.dense.llt().solve(right);
      for (Index i = 0; i < n; ++i) EXPECT_LT((x[i] - expected.row(i).transpose()).norm(), 1e-10 * expected.norm()) << n;
      // One coordinate alone, in place.
      std::vector<double> one(n);
      for (Index i = 0; i < n; ++i) one[i] = b[i].y();
      cholesky.solve(one, one);
      for (Index i = 0; i < n; ++i) EXPECT_NEAR(one[i], expected(i, 1), 1e-10 * expected.norm()) << n;
      // Beside another matrix with the same pattern.
      std::vector<double> weaker = m.values;
      for (double& value : weaker) value *= 0.5;
      ScalarCholesky other = cholesky;
      ASSERT_TRUE(other.factorize(m.diagonal, weaker));
      Eigen::MatrixXd dense = 0.5 * m.dense;
      dense.diagonal() *= 2.0;
      const Eigen::VectorXd expected_last = dense.llt().solve(right.col(0));
      std::vector<double> rows(4 * n);
      for (Index i = 0; i < n; ++i) {
        std::copy_n(b[i].data(), 3, rows.data() + 4 * i);
        rows[4 * i + 3] = b[i].x();
      }
      cholesky.solveWith(other, rows);
      for (Index i = 0; i < n; ++i) {
        for (int c = 0; c < 3; ++c) EXPECT_EQ(rows[4 * i + c], x[i][c]) << n;
        EXPECT_NEAR(rows[4 * i + 3], expected_last[i], 1e-10 * expected_last.norm()) << n;
      }
      // Another matrix, after it.
      for (Index i = 0; i < n; ++i) m.dense(i, i) = m.diagonal[i] *= 1.7;
    }
  }
}

TEST(ScalarCholesky, OrdersSoThatLittleIsFilled) {
  const Index side = 20, n = side * side;
  std::vector<std::pair<Index, Index>> pairs;
  for (Index i = 0; i < side; ++i)
    for (Index j = 0; j < side; ++j) {
      const Index at = i * side + j;
      if (j + 1 < side) pairs.emplace_back(at, at + 1);
      if (i + 1 < side) pairs.emplace_back(at, at + side);
      if (i + 1 < side && j + 1 < side) pairs.emplace_back(at, at + side + 1);
    }
  ScalarCholesky cholesky;
  cholesky.analyze(n, pairs);
  EXPECT_LT(cholesky.factorSize(), 0.65 * n * side);  // row after row it is n side, less a little
}

TEST(ScalarCholesky, TellsThatAMatrixIsNotPositiveAndGoesOnWithTheNext) {
  const Matrix m = makeMatrix(30, 7);
  ScalarCholesky cholesky;
  cholesky.analyze(30, m.pairs);
  std::vector<double> diagonal = m.diagonal;
  diagonal[17] = -1.0;
  EXPECT_FALSE(cholesky.factorize(diagonal, m.values));
  ASSERT_TRUE(cholesky.factorize(m.diagonal, m.values));
  Points b(30, Vec3::Ones()), x;
  cholesky.solve(b, x);
  Eigen::VectorXd expected = m.dense.llt().solve(Eigen::VectorXd::Ones(30));
  for (Index i = 0; i < 30; ++i) EXPECT_NEAR(x[i].y(), expected[i], 1e-10 * expected.norm());
}

TEST(ScalarCholesky, LooksAtAnInterruptWhileItFactorizesAndGoesOnAfterwards) {
  const Matrix m = makeMatrix(300, 7);
  ScalarCholesky cholesky;
  cholesky.analyze(300, m.pairs);
  std::atomic<bool> flag{false};
  const InterruptScope scope(flag);
  ASSERT_TRUE(cholesky.factorize(m.diagonal, m.values));
  std::vector<double> expected(300), x(300);
  cholesky.solve(m.diagonal, expected);
  {
    const LookCounter counter(flag, 3);
    EXPECT_THROW(cholesky.factorize(m.diagonal, m.values), Interrupted);
  }
  flag = false;
  ASSERT_TRUE(cholesky.factorize(m.diagonal, m.values));
  cholesky.solve(m.diagonal, x);
  EXPECT_EQ(x, expected);
}

}  // namespace
}  // namespace deformable_surface::test
