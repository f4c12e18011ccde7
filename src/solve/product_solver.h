// Newton's direction where the stiffness is known by its products alone. Apart from newton.h, which looks for the length of the
// step.
#pragma once

#include "deformable_surface/linear/multigrid.h"
#include "deformable_surface/solve/system.h"

#include <atomic>

namespace deformable_surface::solve {

/// Solves (K + W) d = -g on the free points by conjugate gradients [Hestenes and Stiefel 1952], K the stiffness of the model and
/// the loads, W weights by point. Preconditioned by the springs that the model tells of (StiffnessProducts) and W, as
/// far as a cycle over coarser springs inverts them: these know no direction, so that no rotation of the body makes them worse,
/// and what they differ by bounds the number of products however long the step and however stiff the body.
class ProductSolver {
 public:
  /// Takes the matrix at a state; step: as in System::addStiffness(). Allocates nothing after the first time.
  void prepare(const System& system, double time, const State& state, double step, model::Hessian hessian,
               const std::vector<double>& weight);

  /// direction (n x 3), zero on held points, that leaves no more than `enough` (N) on any point. False: a motion was met along
  /// which the matrix is not positive; direction is then what was found before it, at least the preconditioner's answer. Ends
  /// early once interrupt is true.
  bool solve(const System& system, const Points& gradient, double enough, const std::atomic<bool>* interrupt, Points& direction);

 private:
  void setSprings(const System& system);
  void multiply(const System& system, const Points& v, Points& product);

  std::vector<double> weight_;  // (n) N/m, and what keeps the matrix regular
  BlockSparse loads_;           // their stiffness
  bool has_load_stiffness_ = false;
  Multigrid springs_;
  std::vector<double> known_weight_;  // (n) with which springs_ were made
  std::vector<char> known_held_;
  // Scratch.
  std::vector<double> diagonal_, off_diagonal_;
  Points residual_, preconditioned_, along_, product_;
  Eigen::VectorXd load_vector_, load_product_;
};

}  // namespace deformable_surface::solve
