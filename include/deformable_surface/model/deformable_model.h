// What the solvers and the simulation know of a material: the core that every model has, and which capabilities it offers
// beyond (capabilities.h). Solvers and simulation know no more of a model than this.
#pragma once

#include "deformable_surface/model/capabilities.h"

#include <memory>
#include <vector>

namespace deformable_surface::model {

class DeformableModel {
 public:
  virtual ~DeformableModel() = default;
  /// A model like this one, with scratch of its own, that another thread may use.
  virtual std::unique_ptr<DeformableModel> clone() const = 0;

  /// (n) kg; positive.
  virtual const std::vector<double>& masses() const = 0;

  /// Adds the internal forces, elastic and viscous, in newtons: forces (n x 3). The elastic part is minus the gradient of
  /// elasticEnergy(). Points with equal velocity feel no viscous force.
  virtual void addForces(const State& state, Points& forces) const = 0;
  /// False only if addForces() never looks at the velocities: the same positions then give the same forces.
  virtual bool forcesReadVelocities() const { return true; }

  /// Elastic energy in joules; zero in the rest state.
  virtual double elasticEnergy(const State& state) const = 0;
  /// Size of the terms of which elasticEnergy() is the small difference, J: what its rounding is in proportion to. 0: it is no
  /// difference.
  virtual double energyScale() const { return 0.0; }

  /// Upper bounds, per point, of the sums of the magnitudes of stiffness at rest (N/m) and of damping (N s/m) of its row: what
  /// Gershgorin's theorem needs. (n) each, added to.
  virtual void addRowBounds(const State& state, std::vector<double>& stiffness, std::vector<double>& damping) const = 0;
  /// The largest step, s, with which explicit integrators are stable at this state; 0: to be measured from the stiffness matrix.
  virtual double findStableStep(const State& /*state*/) const { return 0.0; }

  // Capabilities: null where the model has none of that kind. Without stiffness there is no implicit method.
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

// What a model without the capability has, in place of nothing. Found by argument-dependent look-up.
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
/// Positions and velocities are all that a state holds of a model without an inner state.
void beginAtRest(DeformableModel& model, State& state);
void adopt(DeformableModel& model, const State& state);

}  // namespace deformable_surface::model
