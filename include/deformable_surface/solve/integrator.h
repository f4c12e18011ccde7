// Time stepping behind one interface. An integrator advances a state by the caller's step, in as many sub-steps as it needs. It
// reports what it did. It never changes the step, never logs, and never throws because of numbers that are not finite.
#pragma once

#include "deformable_surface/solve/integrator_params.h"
#include "deformable_surface/solve/system.h"

#include <atomic>
#include <memory>
#include <optional>

namespace deformable_surface::solve {

struct SolveReport {
  bool finite = true;     // false: the state is not usable; the caller restores the one before
  bool converged = true;  // implicit and static: the residual fell below the tolerance
  Index substeps = 0;
  Index stopped = 0;  // of these: a limit of motion (MotionLimit) stopped a twentieth of the points or more; of Verlet
  Index halted = 0;   // of these: together, limits of motion (MotionLimit) made more energy than there was motion to take it from
  Index fallbacks = 0;           // of these: taken by another integrator than the chosen one
  Index iterations = 0;          // of Newton's method, or of quasi-Newton steps where these were enough
  double passes = 0.0;           // of Verlet and implicit steps: their work, in evaluations of all forces; counted, not timed
  bool is_quasi_newton = false;  // these are the latter, which cost a few passes of forces each
  double residual = 0.0;         // N, the largest unbalanced force on a free point
  double unbalanced = 0.0;  // share of the largest force that was left by searches that did not converge; the largest of them
  bool is_out_of_iterations = false;  // one of these took max_iterations; the others came no nearer
  bool is_given_up = false;           // it took more work than it may: the state is no result of a step
  double dissipated = 0.0;  // J, that damping by mass took out of the motion; of Verlet for points without orientation, else 0
  // J, work of what moves held points against the forces on them; of Verlet also in collisions (MotionLimit). Of Verlet, of
  // symplectic Euler where something may break, of implicit steps, and of static steps that move them in parts, else unknown.
  std::optional<double> carrying_work;
  double time_forces = 0.0;  // s of wall time in force evaluations

  /// Breaks what is stretched too far in a state that a sub-step has reached.
  void breakStretched(const System& system, const State& state) {
    const std::optional<double> lost = system.breaking() ? system.breaking()->breakStretched(state) : std::nullopt;
    has_broken = has_broken || lost;
    released += lost.value_or(0.0);
  }
  bool has_broken = false;
  double released = 0.0;  // J, elastic energy that went with what broke
};

/// Belongs to one system: what it keeps between steps (forces, the pattern of a matrix) is of that system.
class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Advances state from time by step seconds. max_substep, s: the stable step of explicit methods (see StableStep); the
  /// step is cut in equal sub-steps no longer than a safe share of it. Implicit methods do not read it.
  virtual SolveReport advance(const System& system, double time, double step, double max_substep, State& state) = 0;

  /// Allows the model's slow forces (see DeformableModel) to act once in up to most_inner sub-steps, as long as those together
  /// stay within a safe share of max_slow_step, s. Only Verlet makes use of it; until it is called, all forces act in every
  /// sub-step.
  virtual void setSlowStep(double /*max_slow_step*/, Index /*most_inner*/) {}
  /// Steps end once their work exceeds this, in evaluations of all forces. Only implicit steps make use of it.
  virtual void setMostPasses(double /*most_passes*/) {}
  /// The model's forces have changed since the end of the last step, though the positions may be the same.
  virtual void forgetForces() {}
  /// Overwrites forces (n x 3) with the model's, on held points too, if the last step ended at this state and kept them.
  virtual bool takeLastForces(const System& /*system*/, const State& /*state*/, Points& /*forces*/) const { return false; }

  /// Implicit and static solutions end between two iterations once this is true. The state is then no result
  /// of a step. Null = never.
  void setInterrupt(const std::atomic<bool>* interrupt) { interrupt_ = interrupt; }

 protected:
  const std::atomic<bool>* interrupt_ = nullptr;
};

/// Sub-steps that an explicit integrator takes of a step: enough that each is at most kSafety of the stable one.
Index countSubsteps(double step, double max_substep);

/// Outer steps of equal length, in which slow forces act once, and the sub-steps in each of them.
struct Substeps {
  Index outer, inner;
};
/// The cheapest cut of a step into sub-steps and outer steps that are both short enough, at most most_inner sub-steps an outer
/// step.
Substeps chooseSubsteps(double step, double max_substep, double max_slow_step, Index most_inner);

/// type: not kAuto, which the simulation resolves; oriented: for a system that isOriented(), which has kVerlet and kStatic only.
std::unique_ptr<Integrator> makeIntegrator(IntegratorType type, const IntegratorParams& params, bool oriented = false);

}  // namespace deformable_surface::solve
