// The order in which the rows of a sparse matrix are eliminated, so that few new entries arise. Both Cholesky factorisations use
// it.
#pragma once

#include "deformable_surface/base/types.h"

#include <Eigen/SparseCore>

#include <vector>

namespace deformable_surface {

/// By approximate minimum degree [Amestoy et al. 1996]: the rows in the order of their elimination. lower: the lower triangle of
/// a symmetric matrix with its whole diagonal. Throws Interrupted (base/interrupt.h) within about ten milliseconds, even for
/// large matrices.
std::vector<Index> findFillReducingOrder(Eigen::SparseMatrix<double> lower);

}  // namespace deformable_surface
