// A symmetric sparse matrix of 3 x 3 blocks that is filled again and again in much the same order: where a block stands is found
// on the first pass, later passes only add numbers.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface {

class BlockSparse {
 public:
  /// Starts a new filling of a (3 n x 3 n) matrix; all values become zero. The calls to add() that follow are quickest when they
  /// name the same blocks in the same order as last time; other orders are looked up, and nothing is allocated while every block
  /// was named before.
  void begin(Index n);

  /// Adds to block (i, j). Only the lower triangle is kept: for i != j either (i, j) or (j, i) is added, not both; the block is
  /// the derivative of row i by column j. For i == j the block must be symmetric.
  void add(Index i, Index j, const Mat3& block);

  /// Ends the filling. True if blocks came that were never named before: the pattern is then another, and a factorisation has to
  /// be analysed anew. A block that is no longer named stays in the pattern, as zeros.
  bool finish();

  /// After finish(): of each block column its rows, ascending. The diagonal is always there, as the first.
  const Lists& pattern() const { return pattern_; }
  /// After finish(): the blocks in the order of pattern().items, of which the caller may change the numbers.
  const std::vector<Mat3>& values() const { return values_; }
  std::vector<Mat3>& values() { return values_; }

  /// After finish(): product = A x, (3 n) each.
  void multiply(const Eigen::VectorXd& x, Eigen::VectorXd& product) const;

 private:
  struct Entry {
    Index i, j;  // as added
    Index slot;  // in values_, or -1: not in the pattern
  };
  struct Pending {
    Index row, column;  // row >= column
    Mat3 block;
  };

  Index find(Index i, Index j) const;
  void buildPattern();

  Lists pattern_;
  std::vector<Mat3> values_;
  std::vector<Entry> order_;      // of the calls of the longest pass, the newest for each place
  std::size_t next_ = 0;          // place in it
  std::vector<Pending> pending_;  // blocks that are not in the pattern yet
};

}  // namespace deformable_surface
