// An approximate inverse of matrices of springs between points, for the three coordinates at once. Memory and time are
// proportional to the number of points; for the factor of a compact body they are not (scalar_cholesky.h).
#pragma once

#include "deformable_surface/linear/scalar_cholesky.h"

namespace deformable_surface {

/// One V-cycle by aggregation [Braess 1995]: a damped Jacobi sweep, the same on coarser points that each stand for several, and
/// a sweep again. The coarsest level is solved exactly. It is symmetric and positive definite if the matrix is so and has no
/// positive number off the diagonal: conjugate gradients may use it. Parallel; the same bits for every number of threads.
class Multigrid {
 public:
  /// The pattern: each pair i != j that the (n x n) matrix couples, once. Allocates all memory.
  void analyze(Index n, const std::vector<std::pair<Index, Index>>& pairs);
  /// diagonal (n), and the numbers of the pairs in the order of analyze(). Allocates nothing.
  void setValues(const std::vector<double>& diagonal, const std::vector<double>& values);
  /// x near A^-1 b for each coordinate, (n x 3) each. Allocates nothing.
  void apply(const Points& b, Points& x);

  /// Numbers stored off the diagonals of all levels.
  std::size_t size() const;

 private:
  struct Level {
    Index n = 0;
    std::vector<std::pair<Index, Index>> pairs;
    std::vector<Index> offsets, columns, sources;  // of each row: the other points, and their pairs
    std::vector<double> diagonal, of_pairs;        // the matrix
    std::vector<double> values, inverse;           // the same by rows, and the inverse of the diagonal
    std::vector<Index> aggregate;                  // of each point: where it goes on the next level,
    std::vector<double> share;                     // 1, or 0 of a point that is coupled to none and goes nowhere
    std::vector<Index> first_member, members;      // of each aggregate
    std::vector<Index> next_pair;                  // of each pair, or -1 within an aggregate
    std::vector<double> b, x, start;               // (4 x n) right side, solution, start of the last sweep
  };
  static void makeRows(Level& level);
  static void aggregate(Level& level, Level& next);
  void setLevel(std::size_t l);
  void cycle(std::size_t l);

  std::vector<Level> levels_;  // all but the last, finest first
  Level last_;
  ScalarCholesky factor_;  // of the last
  Points last_b_, last_x_;
};

}  // namespace deformable_surface
