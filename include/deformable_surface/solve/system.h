// The mechanical system as solvers see it: masses, all forces (of the material and of the loads), held points. It never sees a
// concrete model, tool or scene.
#pragma once

#include "deformable_surface/solve/breaking.h"
#include "deformable_surface/solve/external_load.h"
#include "deformable_surface/solve/motion_limit.h"

namespace deformable_surface::solve {

using model::State;

class System {
 public:
  /// The model, the loads and held (n, 1 = no force moves the point: it keeps its velocity) are kept by reference: their values
  /// may change between steps. damping, 1/s: force = -damping * mass * velocity, and torques likewise, unless the model damps
  /// rotation otherwise (OrientedPoints); explicit integrators apply it exactly. held_turns (n, 1 = the point does not turn):
  /// null if no rotation is held.
  System(const model::DeformableModel& model, const std::vector<const ExternalLoad*>& loads, const std::vector<char>& held,
         double damping, const std::vector<char>* held_turns = nullptr);

  Index size() const { return static_cast<Index>(model_.masses().size()); }
  const std::vector<double>& masses() const { return model_.masses(); }
  bool isHeld(Index i) const { return held_[i] != 0; }
  bool isOriented() const { return model::isOriented(model_); }
  /// Of oriented points.
  const std::vector<double>& inertias() const { return model_.orientedPoints()->inertias(); }
  bool isTurnHeld(Index i) const { return held_turns_ && (*held_turns_)[i] != 0; }
  /// (n), 1 = the point does not turn; null if no rotation is held.
  const char* heldTurns() const { return held_turns_ ? held_turns_->data() : nullptr; }
  /// Whether there is an implicit method.
  bool hasStiffness() const { return model_.stiffnessMatrix() || model_.stiffnessProducts(); }
  double damping() const { return damping_; }
  /// 1/s, of the rotation of oriented points: torque = -damping * inertia * spin.
  double rotationalDamping() const { return isOriented() ? model_.orientedPoints()->rotationalDamping(damping_) : damping_; }
  void setDamping(double damping) { damping_ = damping; }
  /// Integrators shorten their steps by this limit from now on. Null, as at first: no limit. Kept by reference.
  void setMotionLimit(const MotionLimit* limit) { motion_limit_ = limit; }
  const MotionLimit* motionLimit() const { return motion_limit_; }
  /// Elements break by it from now on, within steps of Verlet, symplectic Euler and the implicit method. Null, as at first: none
  /// do. Kept by reference.
  void setBreaking(Breaking* breaking) { breaking_ = breaking; }
  Breaking* breaking() const { return breaking_; }
  /// True if anything but the damping by mass may dissipate energy: the material's viscosity, loads without a potential.
  bool dissipatesInForces() const;
  /// The same within a time (s) from a state on: without loads that are too far to act.
  bool mayDissipateInForces(double time, double within, const State& state) const;
  /// The same, damping by mass included.
  bool dissipates() const { return damping_ > 0.0 || rotationalDamping() > 0.0 || dissipatesInForces(); }

  /// All forces but the damping by mass, N; zero on held points. (n x 3), overwritten.
  void computeForces(double time, const State& state, Points& forces) const;
  /// The same on held points too: the forces that their constraints bear.
  void computeForcesOnAll(double time, const State& state, Points& forces) const;
  /// The same as the first, and the torques, N m, of oriented points: (n x 3), overwritten, zero on points that do not
  /// turn.
  void computeForcesAndTorques(double time, const State& state, Points& forces, Points& torques) const;
  /// The model's part of them alone, on held points and on those that do not turn, too.
  void computeElasticForcesAndTorques(const State& state, Points& forces, Points& torques) const;
  /// No torque on points that do not turn.
  void holdTurns(Points& torques) const;
  /// The same on held points too, and on those that do not turn.
  void computeForcesAndTorquesOnAll(double time, const State& state, Points& forces, Points& torques) const;
  /// Forces in parts: the fast and the slow forces of the model alone (see SplitForces), on held points too, overwritten. Loads
  /// are added separately, zero on held points.
  bool hasSlowForces() const { return model_.splitForces() != nullptr; }
  void computeFastForces(const State& state, Points& forces) const;
  void computeSlowForces(const State& state, Points& forces) const;
  void addLoads(double time, const State& state, Points& forces) const;
  void addLoadsOnAll(double time, const State& state, Points& forces) const;  // the same on held points too
  /// The same of some loads: see ExternalLoad::isSplitOff().
  enum class Loads { kAll, kSplitOff, kOthers };
  void addLoadsOnAll(double time, const State& state, Loads which, Points& forces) const;
  bool hasSplitLoads() const;
  /// Those that are split off as if nothing moved, on held points too.
  void addSplitLoadsAtRest(double time, const State& state, Points& forces) const;
  /// See ExternalLoad: to be called by explicit integrators after each sub-step, by implicit ones after each step.
  void remember(double time, double step, State& state) const {
    for (const ExternalLoad* load : loads_) load->remember(time, step, state);
  }
  double boundSlowRate(const State& state) const { return hasSlowForces() ? model_.splitForces()->boundSlowRate(state) : 0.0; }
  /// False: the model's forces are a function of the positions alone.
  bool internalForcesReadVelocities() const { return model_.forcesReadVelocities(); }
  /// Only forces that have a potential: elastic forces and those of conservative loads. Velocities are not read.
  void computeConservativeForces(double time, const State& state, Points& forces) const;
  /// Their potential, J.
  double potentialEnergy(double time, const State& state) const;
  /// J, that of spins included.
  double kineticEnergy(const State& state) const;
  double elasticEnergy(const State& state) const { return model_.elasticEnergy(state); }
  /// See DeformableModel.
  double energyScale() const { return model_.energyScale(); }
  /// The potential of the conservative loads alone, J.
  double loadPotential(double time, const State& state) const;
  /// See ExternalLoad, of the loads with a potential and of the others, W.
  struct DrivingPower {
    double of_potentials, of_others;
  };
  DrivingPower drivingPower(double time, double step, const State& state) const;
  /// The part of it that is stored as in springs, J.
  double storedEnergy(double time, const State& state) const;
  /// The energy that loads put in between two times while the points move straight from one state to another, J (see
  /// ExternalLoad), plus the work of what moves held points, by the trapezoidal rule.
  double estimateWork(double from, double to, const State& before, const State& after) const;
  /// Each of these two alone, J.
  double loadWork(double from, double to, const State& before, const State& after) const;
  double carryingWork(double from, double to, const State& before, const State& after) const;
  /// J, of what moves held points from before to after (n x 3) m against the forces at one state.
  double workAgainst(double time, const State& state, const Points& before, const Points& after) const;
  /// The same for a search for an equilibrium: held points are moved first, all at once, while the others wait. Then the others
  /// descend. This is exact for any length of the path; the trapezoidal rule is not.
  double estimateStaticWork(double from, double to, const State& before, const State& after) const;
  /// The forces of the loads, N; zero on held points and on points whose load has a stiffness. (n x 3), overwritten.
  void computeSteadyLoads(double time, const State& state, Points& forces) const;

  /// See DeformableModel.
  double findStableStep(const State& state) const { return model_.findStableStep(state); }

  /// The symmetric part of -dF/dx - dF/dv / step on all points (also held ones).
  void addStiffness(double time, const State& state, double step, model::Hessian hessian, BlockSparse& stiffness) const;
  /// The skew part of -dF/dx, that of loads without a potential, times v; zero on held points, where v is zero.
  bool hasSkewStiffness() const;
  void computeSkewProduct(double time, const State& state, const Points& v, Points& product) const;
  /// The part of a model's fast forces alone (see SplitForces), positive semidefinite, without damping.
  void addFastStiffness(const State& state, BlockSparse& stiffness) const;

  /// Of a model with StiffnessProducts, see there; the products are zero on held points, v is zero there. Those of the loads
  /// are in addStiffness().
  bool hasStiffnessProducts() const { return model_.stiffnessProducts() != nullptr; }
  void prepareStiffness(const State& state, model::Hessian hessian) const {
    model_.stiffnessProducts()->prepareStiffness(state, hessian);
  }
  void computeStiffnessProduct(const Points& v, Points& product) const;
  using Coupling = model::Coupling;
  const std::vector<Coupling>& couplings() const { return model_.stiffnessProducts()->couplings(); }
  /// See StiffnessMatrix.
  bool findCouplings(const State& state, double support, std::vector<Coupling>& along, std::vector<Coupling>& across) const {
    return model_.stiffnessMatrix() && model_.stiffnessMatrix()->findCouplings(state, support, along, across);
  }
  /// See DeformableModel.
  void computeAreaVectors(const State& state, Points& area_vectors) const {
    model::computeAreaVectors(model_, state, area_vectors);
  }
  /// See PlanarMotion.
  void confine(Points& forces) const {
    if (const model::PlanarMotion* planar = model_.planarMotion()) planar->confine(forces);
  }

  /// See StiffnessMatrix; zero on held points.
  double rankOneStiffness(const State& state, Points& v) const;

  /// The size of the forces that have to balance, N: the largest internal force or load on any point, held ones included.
  double largestForce(double time, const State& state) const;
  /// The same, and computeForces() but for the order of its sums.
  double computeForcesAndLargest(double time, const State& state, Points& forces) const;
  /// The force below which a balance is rounding, N, of each point (n), overwritten: that of positions wrong by one unit in the
  /// last place.
  void computeRounding(double time, const State& state, std::vector<double>& rounding) const;
  /// The same of all, by the place of each point.
  double roundingForce(double time, const State& state) const;

  /// The largest motion of a held point, from before to after (n x 3, m), relative to a free point to which it is linked, as a
  /// share of their distance before.
  double findCarriedStrain(const Points& before, const Points& after) const;

  /// Of each point: the first point of those that the model's links connect it to. All 0 in models without links.
  void labelParts(std::vector<Index>& parts) const;

  /// Upper bound by Gershgorin's theorem of the largest rate of the damping that depends on velocity, of the model and these
  /// loads, 1/s.
  double dampingRate(double time, const State& state, Loads which = Loads::kAll) const;
  /// Upper bound of the largest stiffness of the loads that are not split off over its mass, 1/s^2.
  double loadStiffness(double time, const State& state) const;
  /// The same bounds of those that are.
  struct SplitBounds {
    double damping, stiffness;  // 1/s, 1/s^2
  };
  SplitBounds boundSplitLoads(double time, const State& state) const;
  /// Upper bound by Gershgorin's theorem of the largest stiffness over its mass, of the model and the loads, 1/s^2.
  double boundStiffness(double time, const State& state) const;
  /// Whether the model has its stiffness as a matrix.
  bool hasStiffnessMatrix() const { return model_.stiffnessMatrix() != nullptr; }
  /// Whether all forces have a potential, all stiffness (but that of pressure on closed surfaces) is the model's, in blocks, and
  /// the model knows couplings: what QuasiNewton asks for.
  bool hasElasticityAlone(double time, const State& state) const;

 private:
  bool isAmong(const ExternalLoad& load, Loads which) const {
    return which == Loads::kAll || load.isSplitOff() == (which == Loads::kSplitOff);
  }
  void computeRowBounds(double time, const State& state, Loads which = Loads::kOthers) const;
  void computeLoadBounds(double time, const State& state, Loads which) const;  // without those of the model
  void addLoadBounds(double time, const State& state, Loads which) const;
  /// The largest of bounds (n) over its mass, of free points.
  double largestRow(const std::vector<double>& bounds) const;
  bool hasCarried(const Points& before, const Points& after) const;

  const model::DeformableModel& model_;
  const std::vector<const ExternalLoad*>& loads_;
  const std::vector<char>& held_;
  const std::vector<char>* held_turns_;
  double damping_;
  const MotionLimit* motion_limit_ = nullptr;
  Breaking* breaking_ = nullptr;
  mutable State at_rest_;  // scratch: the positions with velocities of zero
  mutable State placed_;   // scratch: before a step, with held points where they are after it
  mutable Points forces_, loads_alone_, forces_on_all_;
  mutable std::vector<double> row_stiffness_, row_damping_;
};

}  // namespace deformable_surface::solve
