// Solves symmetric positive definite systems of 3 x 3 blocks, many times over with one pattern: a supernodal Cholesky
// factorisation that allocates memory only when the pattern changes.
#pragma once

#include "deformable_surface/linear/block_sparse.h"

namespace deformable_surface {

/// P A P^T = L L^T with P a fill-reducing permutation of the blocks [Amestoy et al. 1996]. Columns of L with the same rows below
/// them form a supernode, stored as one dense panel. A panel first gathers the products of earlier panels that have rows in it,
/// then it is factorised in place (left-looking) [Ng and Peyton 1993]. The bits of the result depend on pattern and values
/// only.
class BlockCholesky {
 public:
  /// pattern: as of BlockSparse, rows >= column, ascending, the diagonal first. Allocates all memory.
  void analyze(const Lists& pattern);

  /// values: the blocks in the order of the analysed pattern. False if the matrix is not positive definite to rounding
  /// (a pivot is not > 0, or not a number): there is then no factor to solve with. Allocates nothing.
  bool factorize(const std::vector<Mat3>& values);

  /// After a factorize() that returned true: x = A^-1 x, (3 n). Allocates nothing.
  void solveInPlace(Eigen::VectorXd& x);

  /// Numbers stored in the factor, including zeros inside panels.
  std::size_t factorSize() const { return factor_.size(); }
  /// Multiplications of a factorize(), including those of such zeros.
  double factorWork() const;

 private:
  // Columns first .. first + width - 1 of L, in blocks of the permuted matrix. The panel is column-major; the rows of its
  // first blocks are those of its own columns.
  struct Node {
    Index first, width;
    Index rows, num_rows;  // place in rows_, and how many
    Index stride;          // numbers from one column of the panel to the next
    std::size_t panel;     // place in factor_
  };
  // Rows begin .. end - 1 of a panel belong to columns of a later node, which subtracts their product.
  struct Update {
    Index node, begin, end;
  };
  // Where a block of the matrix goes in the factor.
  struct Place {
    std::size_t at;
    Index stride;
    bool transposed;
  };

  void order(const Lists& pattern);
  void findNodes();
  void findUpdates();
  void placeBlocks(const Lists& pattern);

  // Made by analyze().
  std::vector<Index> position_;            // of a block of the matrix in the permuted one
  std::vector<Index> parent_;              // of each column of L: the row of its first entry below the diagonal, or -1
  std::vector<std::vector<Index>> below_;  // of each column of L its rows below the diagonal; only while analyze() runs
  std::vector<Node> nodes_;
  std::vector<Index> rows_;
  std::vector<Index> node_of_column_;
  std::vector<Update> updates_;
  std::vector<Index> update_offsets_;  // of node s: updates_ from [s] to [s + 1]
  std::vector<Place> places_;
  // Made by factorize().
  std::vector<double> factor_;
  // Scratch.
  std::vector<Index> row_in_panel_, target_rows_, counting_;
  std::vector<double> permuted_, local_;
};

}  // namespace deformable_surface
