// A block matrix with all of its zeros, to be checked by dense linear algebra.
#pragma once

#include "deformable_surface/linear/block_sparse.h"

namespace deformable_surface::test {

/// Both triangles, (3 n x 3 n). After finish().
inline Eigen::MatrixXd makeDense(const BlockSparse& matrix) {
  const Lists& pattern = matrix.pattern();
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * pattern.size(), 3 * pattern.size());
  for (Index column = 0; column < pattern.size(); ++column)
    for (Index k = pattern.offsets[column]; k < pattern.offsets[column + 1]; ++k) {
      dense.block<3, 3>(3 * pattern.items[k], 3 * column) = matrix.values()[k];
      dense.block<3, 3>(3 * column, 3 * pattern.items[k]) = matrix.values()[k].transpose();
    }
  return dense;
}

}  // namespace deformable_surface::test
