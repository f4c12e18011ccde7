// Equilibria of surfaces by steps that cost a few force passes each. Newton's cost a hundred. The static solver takes over
// where these steps fail.
#pragma once

#include "deformable_surface/solve/integrator.h"
#include "surface_preconditioner.h"

namespace deformable_surface::solve {

/// L-BFGS [Nocedal 1980; Liu and Nocedal 1989] on the free points; the first matrix is that of SurfacePreconditioner. The step
/// length comes from forces alone, by the approximate Wolfe conditions [Hager and Zhang 2005], which need no energy:
/// near an equilibrium energies differ by less than their rounding.
class QuasiNewton {
 public:
  /// Moves state.positions until no force on a free point exceeds tolerance times the largest force there is (System::
  /// largestForce()), or its rounding (n), N. True: it succeeded, and the potential energy is no higher than before; adds to
  /// report.iterations and report.time_forces, and sets report.residual. False: the positions are as before, because a force has
  /// no potential or a stiffness beside the surface's, no preconditioner is known, interrupt became true, or the
  /// forces fell too slowly. The velocities must be zero. Allocates nothing after the first time, except
  /// where tension crosses the share of bending below which bending is included.
  bool solve(const System& system, double time, double tolerance, const std::vector<double>& rounding,
             const std::atomic<bool>* interrupt, State& state, SolveReport& report);

 private:
  // A pair of step and change of gradient.
  struct Pair {
    Eigen::VectorXd step, change;  // of the positions, m, and the gradient's change by it, N; (3 n)
    double inverse = 0.0;          // 1 / (step . change)
    double share = 0.0;            // scratch
  };
  bool descend(const System& system, double time, double tolerance, const std::vector<double>& rounding,
               const std::atomic<bool>* interrupt, State& state, SolveReport& report);
  /// Computes the gradient at state.positions, and scale_, and returns the largest force on a free point above its rounding, N.
  double findGradient(const System& system, double time, const std::vector<double>& rounding, State& state, SolveReport& report);
  void findDirection(const System& system);
  /// Moves state.positions along the direction and stores the pair; false, and unmoved, if no step length is acceptable.
  bool search(const System& system, double time, const std::vector<double>& rounding, State& state, SolveReport& report);
  /// The pair of this age; 0: the newest.
  Pair& remember(Index age) { return pairs_[(num_found_ - 1 - age) % static_cast<Index>(pairs_.size())]; }

  SurfacePreconditioner preconditioner_;
  std::vector<Pair> pairs_;
  Index num_found_ = 0;    // pairs since the beginning, of which the last ones are kept
  double fraction_ = 1.0;  // of the last direction that was taken
  double scale_ = 0.0;     // System::largestForce() at the last gradient, N
  Points forces_, first_;  // first_: positions at the beginning
  Eigen::VectorXd gradient_, gradient_before_, start_, direction_, work_;  // (3 n)
};

}  // namespace deformable_surface::solve
