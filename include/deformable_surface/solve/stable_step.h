// The largest stable step of explicit integrators, from the highest frequency of the system. The frequency is measured
// where the model has a stiffness matrix.
#pragma once

#include "deformable_surface/linear/lanczos.h"
#include "deformable_surface/solve/system.h"

#include <utility>

namespace deformable_surface::solve {

/// Estimates the stable step of a system at a state and keeps its memory between calls.
class StableStep {
 public:
  /// dt = (2 / w) (sqrt(1 + z^2) - z), s, with w the largest angular frequency and z = c / w of the velocity-dependent forces.
  /// The integrators take these from velocities that are predicted with the acceleration of the sub-step before. w^2 is the
  /// largest eigenvalue of M^-1 K by Lanczos iteration with its error bound added, and that of the rank-one part of the stiffness
  /// (the sum bounds the eigenvalue of the sum [Weyl]). In the same way a bound is added for slow forces, where it is small. A
  /// model that knows its stable step gives it, and a bound for the loads is added. For a model without a stiffness matrix w^2 is
  /// bounded by the row bounds of model and loads [Gershgorin]. Infinite if nothing is stiff. Allocates nothing once the
  /// stiffness has its pattern.
  ///
  /// splits: for an integrator that splits loads off (see VelocityVerlet). Their damping c is no part of z, but dt is at most 2 /
  /// c.
  double estimate(double time, const State& state, const System& system, bool splits = false);

  /// System::boundSlowRate() at the state of the last estimate, 1/s^2.
  double slowRate() const { return slow_rate_; }

 private:
  double findLimit(double squared_frequency, double time, const State& state, const System& system, bool splits) const;
  /// Which matrix to measure, and what to add to its largest eigenvalue, 1/s^2. Needs scale_.
  std::pair<const BlockSparse*, double> fillStiffness(double time, const State& state, const System& system);
  /// The largest diagonal entry of M^-1 K on free points, 1/s^2.
  double largestEntry(const BlockSparse& stiffness) const;

  BlockSparse fast_, whole_;  // without and with slow forces
  double slow_rate_ = 0.0;
  Points rank_one_;
  Lanczos lanczos_;
  Eigen::VectorXd scale_, scaled_;  // (3 n); scale_: 1 / sqrt(mass), 0 on held points
};

}  // namespace deformable_surface::solve
