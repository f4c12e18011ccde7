// Implicit methods: the second-order method of two stages by energy descent, and the static equilibrium.
#pragma once

#include "bearing_parts.h"
#include "deformable_surface/solve/integrator.h"
#include "newton.h"
#include "quasi_newton.h"

#include <limits>

namespace deformable_surface::solve {

/// Removes kinetic energy above a limit from the motion after an implicit step.
class EnergyLimit {
 public:
  /// time: s, at the beginning of the step; limit: J. Takes what is above it from the parts that meet others (BearingParts), so
  /// that the others keep their motion. If these have too little: takes it from all if forced, and returns false if not.
  /// Momentum is kept where no point is held; false if that of a free body has more.
  bool apply(const System& system, double time, double step, double limit, bool is_forced, const State& before, State& state);

 private:
  BearingParts bearing_;
};

/// One implicit stage: finds x and v = (x - from) / step with  m (v - velocity) / step = F(time, x, v) - c m v  on the free
/// points, as the minimum of  w/2 |x - y|^2 + E(x) + U(x),  by Newton steps with line search. A single Newton step would not be
/// stable: it can raise the energy a hundredfold.
class ImplicitStage {
 public:
  explicit ImplicitStage(const IntegratorParams& params) : params_(params) {}

  /// from (n x 3) m and velocity (n x 3) m/s: the start of the stage. The search begins at the inertial guess if its potential is
  /// at most `energy`, else at state.positions: every descent from there ends below `energy`. Overwrites state, adds to
  /// report.
  void solve(const System& system, double time, double step, const Points& from, const Points& velocity, double energy,
             State& state, SolveReport& report);
  /// For the solutions from now on, see Integrator.
  void setInterrupt(const std::atomic<bool>* interrupt) { interrupt_ = interrupt; }
  /// Solutions end once report.passes exceeds this, and say so.
  void setMostPasses(double most_passes) { most_passes_ = most_passes; }

  /// One step of implicit Euler from `before`, which equals state. First order, stable at every step, and dissipative: a mode
  /// of frequency w loses the factor (1 + (w h)^2)^(-1/2) per step. Where the energy is not convex between two states (collapse,
  /// buckling) the minimum alone could still gain kinetic energy. Any excess over the energy before plus the work of forces
  /// without a potential is removed (EnergyLimit).
  SolveReport takeEulerStep(const System& system, double time, double step, const State& before, State& state);

  /// Work of the forces without a potential from the last solve's `from` to its end, J.
  double remainderWork(const State& state) const { return newton_.remainderWork(from_, state); }
  /// The same of what its tolerance left unbalanced, J.
  double unbalancedWork(const State& state) const { return newton_.unbalancedWork(from_, state, enough_); }

 private:
  IntegratorParams params_;
  NewtonDescent newton_;
  EnergyLimit energy_limit_;
  BearingParts stopped_;  // at the start of the search
  const std::atomic<bool>* interrupt_ = nullptr;
  double most_passes_ = std::numeric_limits<double>::infinity();
  Points from_, target_, guess_, begin_;
  std::vector<double> weight_, rounding_;
  double enough_ = 0.0;  // N, the unbalanced force that the tolerance allows
};

/// Two implicit stages of the same length; the second ends the step. Second order, exact in free fall, stable at every step, and
/// fast modes still decay [Alexander 1977, the two-stage SDIRK; L-stable]. The energy never rises above its former value plus
/// the work of forces without a potential: a small excess is removed (EnergyLimit). Where that is not possible, implicit Euler
/// takes the step. In impacts the second stage goes on with the force of the first, which would throw a body back faster than it
/// came: such a step gains energy, as seen from what was hit, and implicit Euler takes it.
class ImplicitSecondOrder : public Integrator {
 public:
  explicit ImplicitSecondOrder(const IntegratorParams& params) : stage_(params) {}
  SolveReport advance(const System& system, double time, double step, double max_substep, State& state) override;
  void setMostPasses(double most_passes) override { most_passes_ = most_passes; }

 private:
  ImplicitStage stage_;
  EnergyLimit energy_limit_;
  State before_;
  Points from_, velocity_;
  double most_passes_ = std::numeric_limits<double>::infinity();
};

/// Each step is the equilibrium under the loads at its end; velocities are zero. QuasiNewton searches it first. If that fails,
/// Newton steps begin again from its start, in the energy with a proximal weight M / h^2 that is lowered while they succeed
/// (pseudo-transient continuation). A flat sheet without stiffness against its load is thus led to the equilibrium gradually.
/// A whole step that would raise the energy is taken on trial: large rotations stretch
/// at first, and the next steps undo that. If these do not end lower than before the trial, it is
/// undone and the step is shortened (the watchdog technique [Chamberlain et al. 1982]).
/// Held points that move far move in parts of half a link, 64 at most, with a rough search after each. Moved all at once, they
/// crumple the surface around them, which then often ends in an equilibrium of much more energy. The parts are straight, also of
/// a turn. If all held points move as one rigid body, the free ones move with it instead.
class StaticSolver : public Integrator {
 public:
  explicit StaticSolver(const IntegratorParams& params) : params_(params) {}
  SolveReport advance(const System& system, double time, double step, double max_substep, State& state) override;

 private:
  struct Result {
    bool converged, is_out_of_iterations;
    double scale;  // N, the size of the forces that have to balance; 0 from QuasiNewton
  };
  /// Until no force exceeds tolerance times the largest, or after `most` iterations of Newton's method. step, s, is the first
  /// pseudo-step. Adds to report; the velocities must be zero.
  Result search(const System& system, double time, double step, double tolerance, Index most, State& state, SolveReport& report);
  bool isInterrupted() const { return interrupt_ && *interrupt_; }

  IntegratorParams params_;
  QuasiNewton quasi_newton_;
  NewtonDescent newton_;
  Points carried_;        // velocities of held points, m/s
  Points begin_, end_;    // of the step
  Points anchor_, safe_;  // safe_: the last state with the lowest energy so far
  std::vector<double> weight_, rounding_;
  double enough_ = 0.0;  // N, the unbalanced force that the tolerance allows
};

}  // namespace deformable_surface::solve
