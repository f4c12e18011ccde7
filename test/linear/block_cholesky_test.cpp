#include "deformable_surface/linear/block_cholesky.h"

#include "../support/dense.h"
#include "../support/surfaces.h"
#include "deformable_surface/base/interrupt.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace deformable_surface::test {
namespace {

using Pairs = std::vector<std::pair<Index, Index>>;

// Random blocks on the given pairs and a diagonal that outweighs its row and column by the factor given.
BlockSparse fill(Index n, const Pairs& pairs, double dominance, std::mt19937& generator) {
  BlockSparse matrix;
  matrix.begin(n);
  std::vector<double> weight(n, 0.1);
  for (const auto& [i, j] : pairs) {
    Mat3 block;
    for (int k = 0; k < 9; ++k) block(k / 3, k % 3) = uniform(generator);
    matrix.add(i, j, block);
    const Mat3 size = block.cwiseAbs();
    for (Index p : {i, j}) weight[p] += std::max(size.rowwise().sum().maxCoeff(), size.colwise().sum().maxCoeff());
  }
  for (Index i = 0; i < n; ++i) matrix.add(i, i, dominance * weight[i] * Mat3::Identity());
  matrix.finish();
  return matrix;
}

// Points of a grid in random order, with the pairs within the reach: the pattern of a surface.
Pairs gridPairs(Index side, double reach, std::mt19937& generator) {
  std::vector<Index> at(side * side);
  for (Index i = 0; i < side * side; ++i) at[i] = i;
  std::shuffle(at.begin(), at.end(), generator);
  Pairs pairs;
  for (Index i = 0; i < side * side; ++i)
    for (Index j = 0; j < i; ++j)
      if (std::hypot(at[i] % side - at[j] % side, at[i] / side - at[j] / side) < reach) pairs.emplace_back(i, j);
  return pairs;
}

// Factorises, solves, and compares with a dense factorisation.
void expectToAgree(BlockCholesky& cholesky, const BlockSparse& matrix, std::mt19937& generator) {
  const Eigen::MatrixXd dense = makeDense(matrix);
  Eigen::VectorXd b(dense.rows());
  for (double& value : b) value = uniform(generator);
  const Eigen::LDLT<Eigen::MatrixXd> reference(dense);
  ASSERT_TRUE(cholesky.factorize(matrix.values()));
  ASSERT_GT(reference.vectorD().minCoeff(), 0.0);
  Eigen::VectorXd x = b;
  cholesky.solveInPlace(x);
  const Eigen::VectorXd expected = reference.solve(b);
  EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm());  // rows outweighed by their diagonals: well conditioned
  EXPECT_LT((dense * x - b).norm(), 1e-13 * b.norm());
}

void expectToAgree(Index n, const Pairs& pairs, std::mt19937& generator) {
  const BlockSparse matrix = fill(n, pairs, 1.0, generator);
  BlockCholesky cholesky;
  cholesky.analyze(matrix.pattern());
  expectToAgree(cholesky, matrix, generator);
}

TEST(BlockCholesky, SolvesRandomSystemsAsADenseFactorisationDoes) {
  std::mt19937 generator(1);
  for (Index n : {1, 2, 3, 5, 17, 60})
    for (double density : {0.05, 0.3, 1.0}) {
      Pairs pairs;
      for (Index i = 0; i < n; ++i)
        for (Index j = 0; j < i; ++j)
          if (0.5 * (uniform(generator) + 1.0) < density) pairs.emplace_back(i, j);
      expectToAgree(n, pairs, generator);
    }
}

TEST(BlockCholesky, SolvesOnThePatternOfASurfaceWithPanelsThatAreMergedAndCut) {
  std::mt19937 generator(2);
  expectToAgree(400, gridPairs(20, 1.5, generator), generator);
  expectToAgree(196, gridPairs(14, 4.3, generator), generator);
}

TEST(BlockCholesky, SolvesWhereNothingIsConnectedAndWhereOnePointIsConnectedToAll) {
  std::mt19937 generator(3);
  expectToAgree(40, {}, generator);
  Pairs chains, star;
  for (Index i = 0; i < 38; ++i) chains.emplace_back(i + 2, i);
  for (Index i = 1; i < 70; ++i) star.emplace_back(i, 0);
  expectToAgree(40, chains, generator);
  expectToAgree(70, star, generator);
}

TEST(BlockCholesky, TakesNewValuesAndNewPatterns) {
  std::mt19937 generator(4);
  BlockCholesky cholesky;
  for (double reach : {2.5, 1.5, 3.5}) {
    const Pairs pairs = gridPairs(8, reach, generator);
    cholesky.analyze(fill(64, pairs, 1.0, generator).pattern());
    for (int pass = 0; pass < 2; ++pass) expectToAgree(cholesky, fill(64, pairs, 1.0, generator), generator);
  }
}

TEST(BlockCholesky, CountsTheMultiplicationsOfAFactorisation) {
  std::mt19937 generator(11);
  BlockCholesky apart, full;
  apart.analyze(fill(60, {}, 2.0, generator).pattern());
  Pairs all;
  for (Index i = 0; i < 60; ++i)
    for (Index j = 0; j < i; ++j) all.emplace_back(i, j);
  full.analyze(fill(60, all, 2.0, generator).pattern());
  EXPECT_DOUBLE_EQ(apart.factorWork(), 0.5 * 27.0 * 60);
  // A sixth of the cube of 180 numbers.
  EXPECT_NEAR(full.factorWork(), std::pow(180.0, 3) / 6.0, 0.05 * std::pow(180.0, 3) / 6.0);
}

TEST(BlockCholesky, SaysWhetherTheMatrixIsPositiveDefinite) {
  std::mt19937 generator(5);
  const Pairs pairs = gridPairs(7, 2.5, generator);
  int definite = 0, indefinite = 0;
  for (int k = 0; k < 40; ++k) {
    const BlockSparse matrix = fill(49, pairs, 0.01 * k, generator);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(makeDense(matrix), Eigen::EigenvaluesOnly);
    const double lowest = solver.eigenvalues().minCoeff();
    ASSERT_GT(std::abs(lowest), 1e-6);  // rounding does not decide
    BlockCholesky cholesky;
    cholesky.analyze(matrix.pattern());
    EXPECT_EQ(cholesky.factorize(matrix.values()), lowest > 0.0) << lowest;
    ++(lowest > 0.0 ? definite : indefinite);
  }
  EXPECT_GT(definite, 5);
  EXPECT_GT(indefinite, 5);
}

TEST(BlockCholesky, RecoversFromAMatrixThatIsNotDefiniteOrNotANumber) {
  std::mt19937 generator(6);
  const Pairs pairs = gridPairs(7, 2.5, generator);
  const BlockSparse good = fill(49, pairs, 1.0, generator);
  BlockCholesky cholesky;
  cholesky.analyze(good.pattern());
  for (double value : {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN()})
    for (Index point : {0, 20, 48}) {
      BlockSparse bad = good;
      bad.values()[bad.pattern().offsets[point]](1, 1) = value;
      EXPECT_FALSE(cholesky.factorize(bad.values()));
      expectToAgree(cholesky, good, generator);
    }
}

TEST(BlockCholesky, IsExactOnDiagonalsWhateverTheirSize) {
  BlockSparse matrix;
  matrix.begin(3);
  for (Index i = 0; i < 3; ++i) matrix.add(i, i, std::pow(4.0, 100 * (i - 1)) * Mat3::Identity());
  matrix.finish();
  BlockCholesky cholesky;
  cholesky.analyze(matrix.pattern());
  ASSERT_TRUE(cholesky.factorize(matrix.values()));
  Eigen::VectorXd x = Eigen::VectorXd::Ones(9);
  cholesky.solveInPlace(x);
  for (Index i = 0; i < 3; ++i) EXPECT_EQ(x[3 * i], std::pow(4.0, -100 * (i - 1)));
}

TEST(BlockCholesky, LooksAtAnInterruptWhileItFactorizesAndGoesOnAfterwards) {
  std::mt19937 generator(5);
  constexpr Index kSide = 30;
  const BlockSparse matrix = fill(kSide * kSide, gridPairs(kSide, 2.1, generator), 1.1, generator);
  BlockCholesky cholesky;
  cholesky.analyze(matrix.pattern());
  std::atomic<bool> flag{false};
  const InterruptScope scope(flag);
  long looks = 0;
  {
    const LookCounter counter(flag);
    ASSERT_TRUE(cholesky.factorize(matrix.values()));
    looks = counter.count();
  }
  EXPECT_GT(looks, kSide * kSide / 16);  // panels are no wider
  Eigen::VectorXd expected = Eigen::VectorXd::Ones(3 * kSide * kSide), x = expected;
  cholesky.solveInPlace(expected);
  {
    const LookCounter counter(flag, looks / 2);
    EXPECT_THROW(cholesky.factorize(matrix.values()), Interrupted);
  }
  flag = false;
  ASSERT_TRUE(cholesky.factorize(matrix.values()));
  cholesky.solveInPlace(x);
  EXPECT_EQ(x, expected);
}

}  // namespace
}  // namespace deformable_surface::test
