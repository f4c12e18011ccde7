#include "deformable_surface/linear/block_sparse.h"

#include "../support/dense.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

Mat3 blockOf(double first) {
  Mat3 block;
  for (int k = 0; k < 9; ++k) block(k / 3, k % 3) = first + k;
  return block;
}

Mat3 symmetric(double first) { return blockOf(first) + blockOf(first).transpose(); }

TEST(BlockSparse, SumsBlocksOfEitherTriangleIntoTheLowerOne) {
  BlockSparse matrix;
  matrix.begin(3);
  matrix.add(2, 0, blockOf(1.0));
  matrix.add(0, 2, blockOf(20.0));
  matrix.add(1, 1, symmetric(5.0));
  EXPECT_TRUE(matrix.finish());
  EXPECT_EQ(matrix.pattern().items, (std::vector<Index>{0, 2, 1, 2}));
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(9, 9);
  expected.block<3, 3>(6, 0) = blockOf(1.0) + blockOf(20.0).transpose();
  expected.block<3, 3>(0, 6) = expected.block<3, 3>(6, 0).transpose();
  expected.block<3, 3>(3, 3) = symmetric(5.0);
  EXPECT_EQ(makeDense(matrix), expected);
}

TEST(BlockSparse, AnotherOrderOrFewerBlocksKeepThePattern) {
  BlockSparse matrix;
  matrix.begin(3);
  matrix.add(0, 0, symmetric(1.0));
  matrix.add(1, 0, blockOf(2.0));
  matrix.add(2, 1, blockOf(3.0));
  EXPECT_TRUE(matrix.finish());
  for (int pass = 0; pass < 2; ++pass) {
    matrix.begin(3);
    matrix.add(2, 1, blockOf(3.0));
    matrix.add(0, 1, blockOf(2.0).transpose());
    EXPECT_FALSE(matrix.finish());
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(9, 9);
    expected.block<3, 3>(3, 0) = blockOf(2.0);
    expected.block<3, 3>(0, 3) = blockOf(2.0).transpose();
    expected.block<3, 3>(6, 3) = blockOf(3.0);
    expected.block<3, 3>(3, 6) = blockOf(3.0).transpose();
    EXPECT_EQ(makeDense(matrix), expected);
  }
}

TEST(BlockSparse, AnExactFillingKeepsOnlyWhatItNamed) {
  const auto fill = [](bool with_contact, BlockSparse& matrix) {
    matrix.begin(4);
    matrix.add(1, 0, blockOf(2.0));
    if (with_contact) matrix.add(3, 0, blockOf(4.0));
    matrix.add(2, 1, blockOf(3.0));
  };
  BlockSparse matrix, fresh;
  fill(false, fresh);
  fresh.finish();
  fill(true, matrix);
  EXPECT_TRUE(matrix.finish(true));
  EXPECT_EQ(matrix.pattern().items.size(), fresh.pattern().items.size() + 1);
  for (const bool is_changed : {true, false}) {
    fill(false, matrix);
    EXPECT_EQ(matrix.finish(true), is_changed);
    EXPECT_EQ(matrix.pattern().items, fresh.pattern().items);
    EXPECT_EQ(makeDense(matrix), makeDense(fresh));
  }
  fill(true, matrix);
  EXPECT_TRUE(matrix.finish(true));
  EXPECT_EQ((makeDense(matrix).block<3, 3>(9, 0)), blockOf(4.0));
}

TEST(BlockSparse, AFillingThatIsGivenUpLeavesNothingToTheNext) {
  BlockSparse matrix;
  matrix.begin(3);
  matrix.add(1, 0, blockOf(7.0));
  matrix.add(2, 1, blockOf(8.0));
  matrix.add(2, 0, blockOf(9.0));
  matrix.begin(3);
  matrix.add(1, 0, blockOf(1.0));
  EXPECT_TRUE(matrix.finish());
  matrix.begin(3);
  matrix.add(1, 0, blockOf(1.0));
  matrix.add(2, 1, blockOf(2.0));
  matrix.add(2, 0, blockOf(3.0));
  EXPECT_TRUE(matrix.finish());
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(9, 9);
  expected.block<3, 3>(3, 0) = blockOf(1.0);
  expected.block<3, 3>(6, 3) = blockOf(2.0);
  expected.block<3, 3>(6, 0) = blockOf(3.0);
  EXPECT_EQ(makeDense(matrix), expected + expected.transpose().eval());
}

TEST(BlockSparse, ANewBlockInAnyPassExtendsThePattern) {
  BlockSparse matrix;
  matrix.begin(3);
  matrix.add(0, 0, symmetric(1.0));
  EXPECT_TRUE(matrix.finish());
  for (int pass = 0; pass < 3; ++pass) {
    matrix.begin(3);
    matrix.add(2, 0, blockOf(2.0));
    matrix.add(0, 0, symmetric(1.0));
    matrix.add(2, 0, blockOf(7.0));
    EXPECT_EQ(matrix.finish(), pass == 0);
    EXPECT_EQ((makeDense(matrix).block<3, 3>(0, 0)), symmetric(1.0));
    EXPECT_EQ((makeDense(matrix).block<3, 3>(6, 0)), blockOf(2.0) + blockOf(7.0));
  }
}

TEST(BlockSparse, AnotherSizeStartsAnew) {
  BlockSparse matrix;
  for (Index n : {2, 4, 1}) {
    matrix.begin(n);
    matrix.add(n - 1, 0, symmetric(1.0));
    EXPECT_TRUE(matrix.finish());
    EXPECT_EQ(makeDense(matrix).rows(), 3 * n);
    EXPECT_EQ((makeDense(matrix).bottomLeftCorner<3, 3>()), symmetric(1.0));
  }
}

TEST(BlockSparse, HasADiagonalEvenIfNothingWasAdded) {
  BlockSparse matrix;
  matrix.begin(2);
  EXPECT_TRUE(matrix.finish());
  EXPECT_EQ(matrix.pattern().items, (std::vector<Index>{0, 1}));
  matrix.begin(2);
  EXPECT_FALSE(matrix.finish());
}

TEST(BlockSparse, MultipliesWithBothTriangles) {
  BlockSparse matrix;
  matrix.begin(3);
  matrix.add(0, 0, symmetric(1.0));
  matrix.add(2, 0, blockOf(2.0));
  matrix.add(1, 2, blockOf(3.0));
  matrix.finish();
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(9, -4.0, 4.0);
  Eigen::VectorXd product;
  matrix.multiply(x, product);
  EXPECT_EQ(product, makeDense(matrix) * x);  // whole numbers: no rounding
}

}  // namespace
}  // namespace deformable_surface::test
