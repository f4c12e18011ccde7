// Solves symmetric positive definite systems with one number for each pair of points, for the three coordinates of points at
// once. Compared with blocks (block_cholesky.h) there are nine times fewer numbers to read, and dense panels do not
// pay.
#pragma once

#include "deformable_surface/base/types.h"

#include <utility>

namespace deformable_surface {

/// P A P^T = L D L^T with P a fill-reducing permutation [Amestoy et al. 1996], row by row along the elimination tree [Davis
/// 2005].
class ScalarCholesky {
 public:
  /// The pattern: each pair i != j that the (n x n) matrix couples, once. Allocates all memory.
  void analyze(Index n, const std::vector<std::pair<Index, Index>>& pairs);

  /// diagonal (n), and the numbers of the pairs in the order of analyze(). False if the matrix is not positive definite to
  /// rounding: there is then no factor. Allocates nothing.
  bool factorize(const std::vector<double>& diagonal, const std::vector<double>& values);

  /// x = A^-1 b for each coordinate, (n x 3) each. Allocates nothing.
  void solve(const Points& b, Points& x);

  /// The same for one number per point, (n) each; x may be b.
  void solve(const std::vector<double>& b, std::vector<double>& x);

  /// In place of (n x 4) numbers, row by row: the first three columns with this matrix, the fourth with another of the same
  /// pattern. This takes little more time than three columns. Allocates nothing.
  void solveWith(const ScalarCholesky& of_last, std::vector<double>& rows);

  /// Numbers stored below the diagonal of L.
  std::size_t factorSize() const { return factor_.size(); }

 private:
  std::vector<Index> position_;        // of a point in the permuted matrix
  std::vector<Index> from_;            // of a place in it its point
  std::vector<Index> offsets_, rows_;  // of each column of the permuted matrix its rows above the diagonal
  std::vector<Index> source_;          // and the pair of each
  std::vector<Index> parent_;          // elimination tree, -1 = a root
  std::vector<Index> starts_;          // of each column of L: its place in the factor
  std::vector<Index> factor_rows_;
  std::vector<char> is_paired_;           // 1: of this column and the next the rows below both are the same
  std::vector<double> factor_, inverse_;  // L below the diagonal by columns, and D^-1
  // Scratch.
  std::vector<Index> filled_, flag_, stack_;
  std::vector<double> row_, work_;
};

}  // namespace deformable_surface
