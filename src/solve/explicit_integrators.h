// The explicit integrators: explicit Euler as published, symplectic Euler, velocity Verlet.
#pragma once

#include "bearing_parts.h"
#include "carried_points.h"
#include "deformable_surface/solve/integrator.h"

#include <utility>
#include <vector>

namespace deformable_surface::solve {

/// Work of Verlet's sub-steps, in evaluations of all forces.
double countPasses(const Substeps& cut);

/// x += dt v; v += dt a(x), both from the old state, one step [Su 2007, sec. 4.4]. It amplifies every undamped mode in
/// every step. It exists for comparison with the paper.
class ExplicitEuler : public Integrator {
 public:
  SolveReport advance(const System& system, double time, double step, double max_substep, State& state) override;

 private:
  Points forces_, before_;
};

/// v += dt a(x); x += dt v. First order, no drift of energy.
class SymplecticEuler : public Integrator {
 public:
  SolveReport advance(const System& system, double time, double step, double max_substep, State& state) override;

 private:
  Points forces_, before_;
  State begin_;  // of a sub-step in which something may break
};

/// Half kick, drift, half kick. Second order, no drift of energy, exact in free fall. Forces that depend on velocity are
/// taken at predicted velocities, which keeps the order; damping by mass is applied exactly, half before and half after.
///
/// Loads that damp contact (ExternalLoad::isSplitOff()) are split off: with F all forces at the end of a sub-step but those of
/// their dampers, they take the velocities u = v + F dt / (2 m). With dampers C a kick is then one without them after u' = (1 -
/// dt C / m) u. Verlet without them keeps a quadratic energy of linear systems for steps below 2 / w. This map reduces it for dt
/// c < 2, with c the largest eigenvalue of C / m. So dampers do not shorten the stable step before that. Velocities predicted
/// with the forces of the sub-step before would shorten it by the factor of StableStep::estimate(). The damping is of first order
/// in dt c.
///
/// Slow forces may act in kicks at the ends of outer steps of several sub-steps (the impulse method r-RESPA [Tuckerman 1992]): it
/// is symmetric, so the order stays, and symplectic.
class VelocityVerlet : public Integrator {
 public:
  SolveReport advance(const System& system, double time, double step, double max_substep, State& state) override;
  void setSlowStep(double max_slow_step, Index most_inner) override {
    max_slow_step_ = max_slow_step;
    most_inner_ = most_inner;
  }
  void forgetForces() override { last_positions_.clear(); }
  bool takeLastForces(const System& system, const State& state, Points& forces) const override;

 private:
  void prepare(const System& system, double dt, const State& state);
  void beginForces(const System& system, double time, Index inner, const State& state);
  void bearSlow(const Points& positions);
  void addSlow(Index inner);
  void addAllLoads(const System& system, double time, Index inner, double decay, const State& state,
                   const std::vector<Index>* stopped);
  const std::vector<Index>& limitMotion(const System& system, const MotionLimit& limit, double dt, double half_decay,
                                        bool is_first, const double* force, State& state);
  /// Returns whether there was enough to take it from.
  bool removeStoppingWork(const System& system, State& state);
  void bearLastKick(const System& system, double dt, const std::vector<Index>& stopped, const Points& forces, State& state);

  double max_slow_step_ = 0.0;
  Index most_inner_ = 1;
  Points fast_forces_, slow_forces_, last_positions_;  // the forces belong to last_positions_ between steps
  Points forces_, forces_with_slow_;                   // loads included
  Points at_rest_;                                     // the same, but of loads that are split off as if nothing moved
  State predicted_;
  std::vector<CarriedPoint> carried_;
  double carrying_work_ = 0.0;  // J, of what carries them in the step
  BearingParts bearing_;        // stopped: in the step
  double stopping_work_ = 0.0;  // J, done in the step by limits of motion; negative: taken
  Points before_;               // m, at the beginning of a sub-step, where motion is limited
  std::vector<double> kick_;    // (3 n) dt / 2 over mass, zero on held points
  std::vector<double> mass_;    // (3 n) kg, zero on held points; empty without damping
};

}  // namespace deformable_surface::solve
