// An approximate inverse of a surface's stiffness, for a tenth of the cost of a block factorisation. quasi_newton.h uses
// it.
#pragma once

#include "deformable_surface/linear/scalar_cholesky.h"
#include "deformable_surface/solve/system.h"

namespace deformable_surface::solve {

/// At each point, motion along the surface and across it are solved for separately, each with one number per pair of points
/// (System::findCouplings()): P = (1 - n n^T) A^-1 (1 - n n^T) + n C^-1 n^T with the normals n at a state. Tension and bending
/// are weaker than the membrane by orders of magnitude, so that no single number serves both. What couples the two consists of
/// few long waves, which the quasi-Newton steps learn.
class SurfacePreconditioner {
 public:
  /// Takes the springs and normals at a state; support: see System::findCouplings(). False: the model knows no springs, or they
  /// have no stiffness. Allocates nothing after the first time, while the pairs stay the same.
  bool prepare(const System& system, const State& state, double support);
  /// answer = P force, (3 n) each; zero on held points.
  void apply(const System& system, const Eigen::VectorXd& force, Eigen::VectorXd& answer);

 private:
  struct Part {
    std::vector<System::Coupling> springs;
    ScalarCholesky factor;
    std::vector<std::pair<Index, Index>> pairs;          // that the factor was analysed for
    std::vector<double> diagonal, values;                // the numbers of the matrix
    std::vector<double> diagonal_before, values_before;  // scratch
    bool is_positive = false;
    bool hasPairsOf(const std::vector<System::Coupling>& others) const;
    bool factorize(const System& system, const Part* other = nullptr);
  };
  Part along_;
  Part across_[2];  // of each set of pairs
  Index used_ = 0;  // of across_
  Points normals_;
  bool are_alike_ = false;  // along and across have the same pairs
  // Scratch.
  std::vector<double> rows_;  // (n x 4): of each point the tangential part and the normal one
  Points tangential_;
  std::vector<double> normal_;
};

}  // namespace deformable_surface::solve
