// Time stepping and relaxation of points with orientation (oriented particles). The methods for points without orientation are
// faster without this code.
#pragma once

#include "carried_points.h"
#include "deformable_surface/solve/integrator.h"

#include <vector>

namespace deformable_surface::solve {

/// Half kick, drift, half kick for positions and, in the same sub-steps, orientations: the spins are kicked by torques and
/// orientations drift by the exact exponential, q <- exp(dt w / 2) q. With moments of inertia that are the same about every axis
/// there is no gyroscopic torque and the whole is symplectic and time-reversible (numerics: Verlet on SO(3), splitting). Second
/// order.
class OrientedVerlet : public Integrator {
 public:
  SolveReport advance(const System& system, double time, double step, double max_substep, State& state) override;
  void forgetForces() override { last_positions_.clear(); }
  bool takeLastForces(const System& system, const State& state, Points& forces) const override;

 private:
  enum class When { kBegin, kWithin, kEnd };  // of the step
  bool isAtLastEnd(const System& system, const State& state) const;
  void prepare(const System& system, double half);
  void evaluate(const System& system, double time, const State& state, When when, SolveReport& report);

  std::vector<CarriedPoint> carried_;
  Points forces_, torques_, predicted_;  // N, N m, m/s
  // At the end of the last step: the model's forces and torques, and where they are valid.
  Points elastic_forces_, elastic_torques_, last_positions_;
  Orientations last_orientations_;
  std::vector<double> decay_, kick_, spin_decay_, spin_kick_;  // (3 n) of half a sub-step, as HalfKicks
};

/// The equilibrium under the loads at the end of the step by FIRE [Bitzek 2006, with the corrections of Guenole 2020]: Newtonian
/// motion whose velocity is turned towards the force and stopped whenever it runs uphill. Positions and orientations move
/// together. Both are measured by kinetic energy, so that no scale between them is needed. The final state is at rest.
class FireRelaxation : public Integrator {
 public:
  explicit FireRelaxation(const IntegratorParams& params) : params_(params) {}
  SolveReport advance(const System& system, double time, double step, double max_substep, State& state) override;

 private:
  const IntegratorParams params_;
  Points forces_, torques_, carried_;
};

}  // namespace deformable_surface::solve
