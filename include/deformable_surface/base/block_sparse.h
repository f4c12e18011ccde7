// A symmetric sparse matrix of 3 x 3 blocks that is filled again and again in the same order: the pattern is found on the first
// pass, later passes only add numbers.
#pragma once

#include "deformable_surface/base/types.h"

#include <Eigen/SparseCore>

namespace deformable_surface {

class BlockSparse {
 public:
  /// Starts a new filling of an (3 n x 3 n) matrix; all values become zero. The calls to add() that follow are expected to name
  /// the same blocks in the same order as last time; if they do not, the pattern is made anew.
  void begin(Index n);

  /// Adds to block (i, j). Only the lower triangle is kept: for i != j either (i, j) or (j, i) is added, not both; the block is
  /// the derivative of row i by column j. For i == j the block must be symmetric.
  void add(Index i, Index j, const Mat3& block);

  /// Ends the filling. The lower triangle, valid until the next begin().
  const Eigen::SparseMatrix<double>& finish();

  /// True if the last finish() made a new pattern, so that a factorisation must be analysed anew.
  bool patternChanged() const { return pattern_changed_; }

 private:
  void buildPattern();

  struct Entry {
    Index i, j;    // as added
    Index slot;    // of the block in values_
  };

  Index n_ = -1;
  std::size_t next_ = 0;
  bool replay_ = false;           // entries_ holds a pattern, and the calls so far agree with it
  bool pattern_changed_ = false;
  std::vector<Entry> entries_;
  std::vector<Mat3> pending_;     // blocks of a pass whose pattern is not known yet
  std::vector<Mat3> values_;      // one per distinct block
  std::vector<Index> value_position_;  // (9 per block) position in the matrix's value array, or -1 above the diagonal
  Eigen::SparseMatrix<double> matrix_;
};

}  // namespace deformable_surface
