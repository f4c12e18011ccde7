// Every force on the simulation points that does not come from the material: gravity, pressure, named forces, anchors, tools.
// Loads are evaluated in every sub-step: nothing is frozen over a step. Solvers know neither tools nor models.
#pragma once

#include "deformable_surface/model/deformable_model.h"

#include <limits>

namespace deformable_surface::solve {

class ExternalLoad {
 public:
  virtual ~ExternalLoad() = default;

  /// Adds the load at simulation time `time` (s): forces (n x 3), N.
  virtual void addForces(double time, const model::State& state, Points& forces) const = 0;

  /// Potential of the load, J, where it has one (its forces are minus the gradient). Meaningless if !isConservative().
  virtual double potential(double /*time*/, const model::State& /*state*/) const { return 0.0; }
  virtual bool isConservative() const { return false; }
  /// Whether its forces damp contact. The strength of this damping is a choice, and no measured property. So Verlet may take it
  /// with accuracy of first order, which leaves the stable step as long as without it: see VelocityVerlet.
  virtual bool isSplitOff() const { return false; }
  /// For such a load: adds the forces that it would have if nothing moved, N. These are the forces of its springs.
  virtual void addForcesAtRest(double /*time*/, const model::State& /*state*/, Points& /*forces*/) const {}
  /// Whether the load may take energy out of the motion within a time (s) from a state on. A load that acts only near the points
  /// may say no where it is far.
  virtual bool mayDissipate(double /*time*/, double /*within*/, const model::State& /*state*/) const { return !isConservative(); }
  /// Power of what moves the load itself, as tools move, W: how fast its potential grows at fixed positions, or, without a
  /// potential, its forces times the tools' velocities where they act. step: s, over which time has come here.
  virtual double drivingPower(double /*time*/, double /*step*/, const model::State& /*state*/) const { return 0.0; }
  /// The part of the potential at a time (s) that is stored as in a spring, never negative, J.
  virtual double storedEnergy(double /*time*/, const model::State& /*state*/) const { return 0.0; }

  /// Energy that the load puts in between two times (s) while the points move straight from one state to another, J: the work of
  /// forces without a potential, and at least what a potential gains by changing in time. A load that only takes energy may
  /// return 0. Infinite, the default without a potential, means unknown: no step is then refused for its energy.
  virtual double estimateWork(double /*from*/, double /*to*/, const model::State& /*before*/,
                              const model::State& /*after*/) const {
    return isConservative() ? 0.0 : std::numeric_limits<double>::infinity();
  }

  /// A solver has reached this state by a step (s) and will continue from it. A load with a memory beyond positions and
  /// velocities writes it into the state here. Evaluations read this memory and do not change it.
  virtual void remember(double /*time*/, double /*step*/, model::State& /*state*/) const {}

  /// Adds a positive semidefinite approximation of minus the derivative of the forces: with respect to position, and divided by
  /// step with respect to velocity (step = 0: none).
  virtual void addStiffness(double /*time*/, const model::State& /*state*/, double /*step*/, BlockSparse& /*stiffness*/) const {}
  /// Adds the rest of the symmetric part of minus the derivative with respect to position, which need not be semidefinite.
  /// Without it Newton's iterations may need many more steps.
  virtual void addIndefiniteStiffness(double /*time*/, const model::State& /*state*/, BlockSparse& /*stiffness*/) const {}
  /// Adds the skew part of that derivative, of a load without a potential, times v (n x 3, m).
  virtual void addSkewProduct(double /*time*/, const model::State& /*state*/, const Points& /*v*/, Points& /*product*/) const {}
  virtual bool hasSkewStiffness() const { return false; }

  /// Adds diagonals that bound the derivatives with respect to position (N/m) and velocity (N s/m): upper bounds of their row
  /// sums, or others whose difference from the derivative is positive semidefinite.
  virtual void addRowBounds(double /*time*/, const model::State& /*state*/, std::vector<double>& /*stiffness*/,
                            std::vector<double>& /*damping*/) const {}
};

}  // namespace deformable_surface::solve
