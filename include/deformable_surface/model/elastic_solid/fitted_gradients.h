// Moving least squares for elastic solids: the weight of each neighbour in each fit, fixed at rest. It does not depend on the
// material.
#pragma once

#include "deformable_surface/model/elastic_solid/point_volumes.h"

namespace deformable_surface::model {

/// The linear map at point i that fits the motion of its neighbours best, weighted by w_ij:
///   F_i = A_i K_i^-1,  A_i = sum_j (x_j - x_i) m_ij^T,  K_i = sum_j (X_j - X_i) m_ij^T,  m_ij = w_ij (X_j - X_i),
/// x now and X at rest: exact where the motion is linear. Weights are symmetric, w_ij = (1 - r^2 / h_ij^2)^2 d_ij / h_ij^2 with
/// the weight d_ij of the detour over the body and the mean h_ij of the reaches of i and j. They vanish at the rim, so that it
/// makes no difference whether a point at the rim is included.
struct PairFit {
  Lists pairs;                  // (n) neighbours with weight, symmetric, ascending
  std::vector<double> m;        // (4 x pairs) m_ij, 1/m, and w_ij, 1/m^2
  std::vector<double> inverse;  // (6 x n) of K_i: xx, xy, xz, yy, yz, zz; pseudo-inverse where neighbours span no volume
  std::vector<char> rank;       // (n) directions in which the neighbours of a point spread, 0 .. 3

  Index size() const { return pairs.size(); }
  Mat3 inverseAt(Index i) const;
};

/// points (n x 3) m at rest; neighbors: lists, nearest first; detours: weight of each listed pair in [0, 1], or empty = 1;
/// reach: in local spacings, measured from the three nearest. Parallel; O(n k).
PairFit fitPairs(const Points& points, const Lists& neighbors, const std::vector<double>& detours, double reach);

/// The rows of a gradient at points, grad u (i) = sum_j (u_j - u_i) g_ij^T, exact where u is linear, g_ij = K_i^-1 m_ij + d_ij.
/// The correction d_ij is the smallest one, by sum_ij V_i^2 |d_ij|^2 / w_ij, with which the sum over the points keeps Gauss's
/// theorem for linear u,
///   sum_i V_i g_i(j) = a_j,  g_i(i) = -sum_j g_ij,
/// a_j the area vector of j's part of the boundary (zero inside). Without it a body under uniform stress is not in equilibrium on
/// irregular points, and no refinement helps [Krongauz and Belytschko 1997; Chen et al. 2013]. On the boundary, a_j is shifted so
/// that the theorem can be satisfied.
struct ConsistentGradients {
  std::vector<double> row;  // (3 x pairs) g_ij, 1/m; pairs as in the fit
  Points own;               // (n x 3) sum_j g_ij
  double residual = 0.0;    // of the theorem, the largest over the points, over the largest there was without correction
};

/// O(n k) for every iteration of conjugate gradients; there are a few hundred at most.
ConsistentGradients makeConsistent(const Points& points, const PairFit& fit, const PointCells& cells);

}  // namespace deformable_surface::model
