// The order of elimination is the same whether or not it can be interrupted. An interrupt ends the search at once.
#include "deformable_surface/linear/fill_reducing_order.h"
#include "deformable_surface/base/interrupt.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <iterator>

namespace deformable_surface {
namespace {

// The lower triangle of a grid's Laplacian.
Eigen::SparseMatrix<double> makeGrid(int side) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < side * side; ++i) {
    entries.emplace_back(i, i, 4.0);
    if (i % side > 0) entries.emplace_back(i, i - 1, -1.0);
    if (i >= side) entries.emplace_back(i, i - side, -1.0);
  }
  Eigen::SparseMatrix<double> matrix(side * side, side * side);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

TEST(FillReducingOrder, IsAPermutationAndTheSameUnderAnInterrupt) {
  for (const int side : {3, 20, 60}) {
    const std::vector<Index> alone = findFillReducingOrder(makeGrid(side));
    std::atomic<bool> flag{false};
    const InterruptScope scope(flag);
    EXPECT_EQ(findFillReducingOrder(makeGrid(side)), alone) << side;
    std::vector<Index> sorted = alone;
    std::sort(sorted.begin(), sorted.end());
    for (Index i = 0; i < static_cast<Index>(sorted.size()); ++i) ASSERT_EQ(sorted[i], i);
  }
}

TEST(FillReducingOrder, OfALargeMatrixEndsWithTheInterrupt) {
  std::atomic<bool> flag{true};
  const InterruptScope scope(flag);
  EXPECT_THROW(findFillReducingOrder(makeGrid(60)), Interrupted);
}

std::ptrdiff_t countThreads() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), std::filesystem::directory_iterator());
}

// The ordering takes longer than the first wait for it, and goes on after the interrupt.
TEST(FillReducingOrder, FewGoOnAfterTheyWereInterrupted) {
  const std::ptrdiff_t before = countThreads();
  for (int k = 0; k < 6; ++k) {
    std::atomic<bool> flag{false};
    const InterruptScope scope(flag);
    const LookCounter counter(flag, 2);
    EXPECT_THROW(findFillReducingOrder(makeGrid(400)), Interrupted);
  }
  EXPECT_LE(countThreads() - before, 2);
  std::atomic<bool> flag{false};
  const InterruptScope scope(flag);
  EXPECT_EQ(findFillReducingOrder(makeGrid(60)), findFillReducingOrder(makeGrid(60)));
}

}  // namespace
}  // namespace deformable_surface
