// The largest step with which an explicit integrator is stable: from the highest frequency of the system, measured instead of
// bounded.
#pragma once

#include "deformable_surface/linear/lanczos.h"
#include "deformable_surface/solve/system.h"

namespace deformable_surface::solve {

/// Estimates the stable step of a system at a state and keeps its memory between calls.
class StableStep {
 public:
  /// dt = (2 / w) (sqrt(1 + z^2) - z), s, with w the largest angular frequency and z = c / (2 w) the damping ratio of the
  /// velocity-dependent forces, which the integrators take from predicted velocities. w^2 is the largest eigenvalue of M^-1 K by
  /// Lanczos iteration with its error bound added, and that of the rank-one part of the stiffness (the sum bounds the eigenvalue
  /// of the sum [Weyl]); or it is the model's own, with a bound for the loads, where a model knows it. Infinite if nothing is
  /// stiff. Allocates nothing once the stiffness has its pattern.
  double estimate(double time, const State& state, const System& system);

 private:
  BlockSparse stiffness_;
  Points rank_one_;
  Lanczos lanczos_;
  Eigen::VectorXd scale_, scaled_;  // (3 n)
};

}  // namespace deformable_surface::solve
