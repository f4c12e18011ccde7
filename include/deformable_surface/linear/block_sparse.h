// A symmetric sparse matrix of 3 x 3 blocks that is filled repeatedly in nearly the same order. The first pass finds the place
// of each block; later passes only add numbers.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface {

class BlockSparse {
 public:
  /// Starts a new filling of a (3 n x 3 n) matrix; all values become zero. The following calls of add() are fastest when they
  /// name the same blocks in the same order as last time. Other orders need a look-up. Nothing is allocated if every block was
  /// named before.
  void begin(Index n);

  /// Adds to block (i, j). Only the lower triangle is stored: for i != j add either (i, j) or (j, i), not both. The block is the
  /// derivative of row i by column j. For i == j the block must be symmetric.
  void add(Index i, Index j, const Mat3& block);

  /// Ends the filling. True if the pattern has changed: a factorisation must be analysed again. A block that this filling did not
  /// name stays in the pattern, as zeros. exactly: it leaves, so that the pattern does not depend on earlier fillings.
  bool finish(bool exactly = false);

  /// After finish(): the rows of each block column, ascending. The diagonal is always present, as the first.
  const Lists& pattern() const { return pattern_; }
  /// After finish(): the blocks in the order of pattern().items. The caller may change their numbers.
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
  void buildPattern(bool exactly);
  void listRows();

  Lists pattern_;
  Lists left_;  // of each row: the place of each block left of the diagonal in values_, and its column
  std::vector<Mat3> values_;
  std::vector<char> named_;       // of each of them: by this filling, or on the diagonal
  std::vector<Entry> order_;      // of the calls of the longest pass, the newest for each place
  std::size_t next_ = 0;          // place in it
  std::vector<Pending> pending_;  // blocks that are not in the pattern yet
};

}  // namespace deformable_surface
