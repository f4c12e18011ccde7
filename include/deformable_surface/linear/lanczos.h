// An upper bound of the largest eigenvalue of a symmetric operator that is known by its products alone. Matrices and matrix-free
// models use it.
#pragma once

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/random.h"

#include <Eigen/Eigenvalues>

#include <cmath>
#include <cstdint>

namespace deformable_surface {

/// Largest eigenvalue by Lanczos iteration, plus the residual that bounds its error. allowed: (n) 0 where vectors must stay
/// zero. apply(v, product) overwrites product with the operator times v, (n) each. Allocates nothing once the scratch is sized.
class Lanczos {
 public:
  template <class Apply>
  double boundLargest(const Eigen::VectorXd& allowed, const Apply& apply) {
    const Index n = static_cast<Index>(allowed.size());
    // A start vector with a part of every mode, always the same.
    std::uint32_t seed = kRandomSeed;
    for (Eigen::VectorXd* vector : {&v_, &w_, &previous_}) vector->resize(n);
    for (Index i = 0; i < n; ++i) {
      nextRandom(seed);
      v_[i] = allowed[i] > 0.0 ? 0.5 + static_cast<double>(seed >> 8) / (1u << 24) : 0.0;
      if ((seed >> 5) & 1u) v_[i] = -v_[i];
    }
    const double norm = v_.norm();
    if (!(norm > 0.0)) return 0.0;
    v_ /= norm;
    // The tridiagonal matrix, on the stack.
    using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kSteps, kSteps>;
    Small tridiagonal = Small::Zero(kSteps, kSteps);
    double beta = 0.0;
    int m = 0;
    do {
      apply(v_, w_);
      const bool is_first = m == 0;
      if (!is_first) tridiagonal(m - 1, m) = tridiagonal(m, m - 1) = beta;
      const double alpha = parallelSum(n, kBlock, [&](Index begin, Index end) {
        auto w = w_.segment(begin, end - begin);
        if (!is_first) w -= beta * previous_.segment(begin, end - begin);
        return w.dot(v_.segment(begin, end - begin));
      });
      tridiagonal(m, m) = alpha;
      ++m;
      beta = std::sqrt(parallelSum(n, kBlock, [&](Index begin, Index end) {
        auto w = w_.segment(begin, end - begin);
        w -= alpha * v_.segment(begin, end - begin);
        return w.squaredNorm();
      }));
      if (!(beta > 1e-12 * std::abs(tridiagonal(0, 0)))) break;
      previous_.swap(v_);
      parallelFor(n, kBlock,
                  [&](Index begin, Index end) { v_.segment(begin, end - begin) = w_.segment(begin, end - begin) / beta; });
    } while (m < kSteps);
    const Eigen::SelfAdjointEigenSolver<Small> solver(tridiagonal.topLeftCorner(m, m));
    return solver.eigenvalues()[m - 1] + beta * std::abs(solver.eigenvectors()(m - 1, m - 1));
  }

 private:
  // The largest eigenvalue of meshes is then known to about a percent. The residual bounds the error.
  static constexpr int kSteps = 30;
  static constexpr Index kBlock = 3072;  // numbers per task: a microsecond of work
  Eigen::VectorXd v_, w_, previous_;
};

}  // namespace deformable_surface
