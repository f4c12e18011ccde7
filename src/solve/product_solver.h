// The Newton direction of models whose stiffness is known only by products with vectors. newton.h finds the length of the
// step.
#pragma once

#include "deformable_surface/linear/multigrid.h"
#include "deformable_surface/solve/system.h"

#include <atomic>

namespace deformable_surface::solve {

/// Solves (K + W) d = -g on the free points by conjugate gradients [Hestenes and Stiefel 1952], K the stiffness of the model and
/// the loads, W weights by point. The preconditioner is one multigrid cycle on W and the springs of the model
/// (StiffnessProducts::couplings()). The springs have no direction, so that rotations of the body do not make them worse. Their
/// difference from K bounds the number of products, for any step length and stiffness.
class ProductSolver {
 public:
  /// Takes the matrix at a state; step: as in System::addStiffness(). Allocates nothing after the first time.
  void prepare(const System& system, double time, const State& state, double step, model::Hessian hessian,
               const std::vector<double>& weight);

  /// direction (n x 3), zero on held points, with a residual of at most `enough` (N) on any point. False: the matrix is not
  /// positive along a direction that was met. The result is then the iterate before it, at least the preconditioner's answer.
  /// Ends early once interrupt is true.
  bool solve(const System& system, const Points& gradient, double enough, const std::atomic<bool>* interrupt, Points& direction);
  /// Of the last solve().
  Index numProducts() const { return num_products_; }

 private:
  void setSprings(const System& system);
  void multiply(const System& system, const Points& v, Points& product);

  std::vector<double> weight_;  // (n) N/m, plus a term that keeps the matrix regular
  BlockSparse loads_;           // their stiffness
  bool has_load_stiffness_ = false;
  Multigrid springs_;
  std::vector<double> known_weight_;  // (n) with which springs_ were made
  std::vector<char> known_held_;
  Index num_products_ = 0;
  // Scratch.
  std::vector<double> diagonal_, off_diagonal_;
  Points residual_, preconditioned_, along_, product_;
  Eigen::VectorXd load_vector_, load_product_;
};

}  // namespace deformable_surface::solve
