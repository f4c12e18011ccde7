// The methods that solve for the end of the step: implicit Euler by energy descent, and the static equilibrium.
#pragma once

#include "deformable_surface/solve/integrator.h"
#include "newton.h"

namespace deformable_surface::solve {

/// x = argmin 1/(2 h^2) |x - y|_M^2 + E(x) + U(x), y = x_n + h v_n: implicit Euler as a minimum, reached by projected Newton
/// steps with line search. A single Newton step would not be stable: it can raise the energy a hundredfold. First order,
/// stable at every step, and it damps: a mode of frequency w loses the factor (1 + (w h)^2)^(-1/2) per step.
/// Where the energy is not convex between two states (collapse, buckling) the minimum alone could still gain kinetic energy; what
/// exceeds the energy there was before, plus the work of forces without a potential, is taken from the motion relative to the mean.
class ImplicitEuler : public Integrator {
 public:
  explicit ImplicitEuler(const IntegratorParams& params) : params_(params) {}
  SolveReport advance(const System& system, double time, double step, double max_substep, State& state) override;

 private:
  void startFromLower(const System& system, double time, double energy, State& state) const;
  void limitKineticEnergy(const System& system, double limit, State& state) const;

  IntegratorParams params_;
  NewtonDescent newton_;
  Points before_, target_;
  std::vector<double> weight_;
};

/// Each step is the equilibrium under the loads at its end; velocities are zero. Newton steps in the energy with a proximal weight
/// M / h^2 that is lowered while they succeed (pseudo-transient continuation), so that a flat sheet without stiffness against
/// its load is led to the equilibrium instead of thrown.
class StaticSolver : public Integrator {
 public:
  explicit StaticSolver(const IntegratorParams& params) : params_(params) {}
  SolveReport advance(const System& system, double time, double step, double max_substep, State& state) override;

 private:
  IntegratorParams params_;
  NewtonDescent newton_;
  Points anchor_;
  std::vector<double> weight_;
};

}  // namespace deformable_surface::solve
