// The interface of material models for solvers and simulation: the core that every model has, and the capabilities that it may
// have beyond (capabilities.h). Solvers and simulation use nothing else of a model.
#pragma once

#include "deformable_surface/model/capabilities.h"

#include <memory>
#include <vector>

namespace deformable_surface::model {

class DeformableModel {
 public:
  virtual ~DeformableModel() = default;
  /// A copy of this model with scratch memory of its own, for another thread.
  virtual std::unique_ptr<DeformableModel> clone() const = 0;

  /// (n) kg; positive.
  virtual const std::vector<double>& masses() const = 0;

  /// Adds the internal forces, elastic and viscous, in newtons: forces (n x 3). The elastic part is minus the gradient of
  /// elasticEnergy(). Points with equal velocity feel no viscous force.
  virtual void addForces(const State& state, Points& forces) const = 0;
  /// False only if addForces() never reads velocities: the same positions then give the same forces.
  virtual bool forcesReadVelocities() const { return true; }

  /// Elastic energy in joules; zero in the rest state.
  virtual double elasticEnergy(const State& state) const = 0;
  /// Size of the terms of which elasticEnergy() is a small difference, J: its rounding error is proportional to it. 0: the energy
  /// is no difference.
  virtual double energyScale() const { return 0.0; }

  /// Upper bounds, per point, of the row sums of the magnitudes of stiffness at rest (N/m) and of damping (N s/m), as used in
  /// Gershgorin's theorem. (n) each, added to.
  virtual void addRowBounds(const State& state, std::vector<double>& stiffness, std::vector<double>& damping) const = 0;
  /// The largest stable step of explicit integrators, s; 0: from the stiffness matrix or, without one, from addRowBounds().
  virtual double findStableStep(const State& /*state*/) const { return 0.0; }

  // Capabilities: null if the model does not have it. Without stiffness there is no implicit method.
  virtual const StiffnessMatrix* stiffnessMatrix() const { return nullptr; }
  virtual const StiffnessProducts* stiffnessProducts() const { return nullptr; }
  virtual const SplitForces* splitForces() const { return nullptr; }
  virtual const OrientedPoints* orientedPoints() const { return nullptr; }
  virtual const PlanarMotion* planarMotion() const { return nullptr; }
  virtual const Partition* partition() const { return nullptr; }
  virtual const Sides* sides() const { return nullptr; }
  virtual const Links* links() const { return nullptr; }
  virtual const Stresses* stresses() const { return nullptr; }
  virtual InnerState* innerState() { return nullptr; }
  virtual PointMaterials* pointMaterials() { return nullptr; }
  virtual Clamping* clamping() { return nullptr; }
};

// Defaults for models without the capability. Found by argument-dependent look-up.
inline bool isOriented(const DeformableModel& model) { return model.orientedPoints() != nullptr; }
inline bool isClosed(const DeformableModel& model) { return model.sides() && model.sides()->isClosed(); }
const std::vector<WeightedTriangle>& trianglesOf(const DeformableModel& model);
const std::vector<std::pair<Index, Index>>& stretchLinksOf(const DeformableModel& model);
const std::vector<std::pair<Index, Index>>& bendLinksOf(const DeformableModel& model);
/// 0 without links.
double maxStretchOf(const DeformableModel& model, const State& state);
/// (n), overwritten: zero without links.
void computePointStrain(const DeformableModel& model, const State& state, std::vector<double>& strain);
/// (n x 3) m^2, overwritten: zero without sides.
void computeAreaVectors(const DeformableModel& model, const State& state, Points& area_vectors);
/// Without an inner state, positions and velocities are all that a state holds.
void beginAtRest(DeformableModel& model, State& state);
void adopt(DeformableModel& model, const State& state);

}  // namespace deformable_surface::model
