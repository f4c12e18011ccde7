// What models may offer beyond the core (deformable_model.h). Each capability is an interface. A model derives from those that it
// has, and returns itself where the core asks for them.
#pragma once

#include "deformable_surface/linear/block_sparse.h"
#include "deformable_surface/model/state.h"

#include <limits>
#include <memory>
#include <utility>
#include <vector>

namespace deformable_surface::model {

class DeformableModel;

/// The material of a point, relative to the material that its model was made with; all positive.
struct PointMaterial {
  double stretching = 1.0;  // of E h
  double bending = 1.0;     // of D
  double density = 1.0;

  bool operator==(const PointMaterial& o) const {
    return stretching == o.stretching && bending == o.bending && density == o.density;
  }
};

/// A material that may differ from point to point.
class PointMaterials {
 public:
  /// Sets the material of each point, (n). Elements between points take the mean of theirs. Forces stay the gradient of the
  /// energy, and the stiffness keeps its pattern.
  virtual void setMaterial(const std::vector<PointMaterial>& materials) = 0;

 protected:
  ~PointMaterials() = default;
};

/// Where a clamp ends, beside one of the points that it holds.
struct ClampEdge {
  Index point;
  Vec3 place;  // m, on the surface at rest

  bool operator==(const ClampEdge& o) const { return point == o.point && place == o.place; }
};

/// Forces that depend on which points are held.
class Clamping {
 public:
  /// From now on forces do not move these points (n): 0 = free, else the number of the patch that they move with. edges: where
  /// clamped patches end, ascending points. Held points beside free ones that have no edge are hinges. Returns whether forces
  /// and stiffness have changed.
  virtual bool setHeld(const std::vector<char>& held, const std::vector<ClampEdge>& edges) = 0;

 protected:
  ~Clamping() = default;
};

/// Which matrix a solver asks for. kPositive: each element's part projected to positive semidefinite, which guarantees a descent
/// direction. kExact: as it is, except for terms that a model documents as left out; it converges faster where it happens to be
/// definite.
enum class Hessian { kPositive, kExact };

/// Some of the elastic forces may allow a longer step than the others. addForces() then equals addFastForces() followed by
/// addSlowForces(), bit for bit.
class SplitForces {
 public:
  virtual void addFastForces(const State& state, Points& forces) const = 0;
  /// They never read velocities.
  virtual void addSlowForces(const State& state, Points& forces) const = 0;
  /// The part of the fast forces in StiffnessMatrix::addStiffness().
  virtual void addFastStiffness(const State& state, double step, Hessian hessian, BlockSparse& stiffness) const = 0;
  /// Upper bound of the largest eigenvalue of M^-1 K, with K the rest of it with Hessian::kPositive, 1/s^2.
  virtual double boundSlowRate(const State& state) const = 0;

 protected:
  ~SplitForces() = default;
};

/// The points carry orientations, which torques turn. State then has the arrays for them.
class OrientedPoints {
 public:
  /// (n) kg m^2, positive: moments of inertia, the same about every axis.
  virtual const std::vector<double>& inertias() const = 0;
  /// 1/s, of rotation: torque = -damping * inertia * spin. motion: 1/s, the damping of motion.
  virtual double rotationalDamping(double motion) const { return motion; }
  /// Adds forces as addForces() does, and the torques in N m: torques (n x 3).
  virtual void addForcesAndTorques(const State& state, Points& forces, Points& torques) const = 0;

 protected:
  ~OrientedPoints() = default;
};

/// The state holds more than positions and velocities, or its number of points changes.
class InnerState {
 public:
  /// Fills everything but positions and velocities of a state at rest, which has as many points as at the beginning.
  virtual void beginAtRest(State& state) = 0;
  /// The state may have changed (points added or removed, a snapshot restored): masses follow.
  virtual void adopt(const State& state) = 0;
  /// For models whose elements depend on the state: Partition uses the elements of this state from now on. They are valid
  /// while no point moves farther than Partition::maxPartMotion(). Returns whether it is such a model.
  virtual bool followPartners(const State& /*state*/) { return false; }

 protected:
  ~InnerState() = default;
};

/// A part of the points can be simulated alone, while the others rest.
class Partition {
 public:
  /// m, see InnerState::followPartners(); infinite for models whose elements do not change.
  virtual double maxPartMotion() const { return std::numeric_limits<double>::infinity(); }
  /// Marks (n, 1) all points that share an element with one of these: the forces on these depend on their positions. False:
  /// the model cannot be divided as it is, and nothing is marked.
  virtual bool markPartners(const std::vector<Index>& points, std::vector<char>& marked) const = 0;
  /// A model of a part of the points.
  struct Part {
    std::unique_ptr<DeformableModel> model;  // null: it cannot be taken in parts
    std::vector<Index> points;               // ascending: which of the whole each of its points is
  };
  /// The elements that touch a wanted point, wanted (n), with all of their points. On wanted points its forces equal those of the
  /// whole model, bit for bit (to rounding, for solids and for links without length). The part is open, and its points stay
  /// held as they are now.
  virtual Part makePart(const std::vector<char>& wanted) const = 0;

 protected:
  ~Partition() = default;
};

/// The points stay in a plane.
class PlanarMotion {
 public:
  /// Removes from forces (n x 3) on the points the components across the plane.
  virtual void confine(Points& forces) const = 0;

 protected:
  ~PlanarMotion() = default;
};

/// A spring with the same stiffness in every direction.
struct Coupling {
  Index i, j;
  double stiffness;  // N/m
};

/// The stiffness as a matrix, for implicit methods.
class StiffnessMatrix {
 public:
  /// Adds the Hessian of the elastic energy, N/m. step: the time over which a solver differentiates velocities; the viscous
  /// forces add their damping matrix divided by it (0 = statics, no viscous part).
  virtual void addStiffness(const State& state, double step, Hessian hessian, BlockSparse& stiffness) const = 0;
  /// The part of the Hessian that couples all points, c v v^T (constant volume): returns c >= 0 and, if it is not zero,
  /// overwrites v (n x 3); c |v|^2 is in N/m.
  virtual double rankOneStiffness(const State& /*state*/, Points& /*v*/) const { return 0.0; }

  /// Sparse spring approximation of the stiffness of a surface (Sides) at a state, for preconditioning: `along` for motion in the
  /// surface, fixed at rest, and `across` for motion out of it. Some springs are negative; all together never gain energy. Each
  /// pair once, i < j, one of two sets of pairs until the model is changed; overwritten. support: where there is tension, this
  /// share of its mean is added everywhere, and more where weak bending is left out. It prevents steps into folds, where almost
  /// nothing resists. False: none are known.
  virtual bool knowsCouplings() const { return false; }
  virtual bool findCouplings(const State& /*state*/, double /*support*/, std::vector<Coupling>& /*along*/,
                             std::vector<Coupling>& /*across*/) const {
    return false;
  }

 protected:
  ~StiffnessMatrix() = default;
};

/// The stiffness by its products with vectors, for models whose matrix would be too full.
class StiffnessProducts {
 public:
  /// Stores, as scratch, the Hessian of the elastic energy at a state. Products use it until the next call.
  virtual void prepareStiffness(const State& state, Hessian hessian) const = 0;
  /// Adds K v: v (n x 3) m, product (n x 3) N.
  virtual void addStiffnessProduct(const Points& v, Points& product) const = 0;
  /// Sparse spring approximation of the stiffness at rest, used as a preconditioner of the products.
  /// Each pair once, i < j.
  virtual const std::vector<Coupling>& couplings() const = 0;

 protected:
  ~StiffnessProducts() = default;
};

/// A triangle of the simulation points with a weight for its area. Where several Delaunay triangulations are possible
/// (cocircular points), all are kept and share the area, so that weights times areas cover the surface once.
struct WeightedTriangle {
  Index corner[3];  // counter-clockwise seen from outside
  double weight;    // 0 .. 1
};

/// The points form a surface, which has an outside.
class Sides {
 public:
  /// The triangles of the surface, for display, area, volume and contact.
  virtual const std::vector<WeightedTriangle>& triangles() const = 0;
  /// Area vector of each point, m^2: outward normal times its share of the current area. (n x 3), overwritten.
  virtual void computeAreaVectors(const State& state, Points& area_vectors) const = 0;
  /// True if the surface has no boundary.
  virtual bool isClosed() const = 0;
  /// Volume enclosed by a closed surface, m^3, and its gradient by the positions, m^2, which sums to zero exactly: (n x 3),
  /// overwritten.
  virtual double enclosedVolume(const State& state) const = 0;
  virtual void computeVolumeGradient(const State& state, Points& gradient) const = 0;

 protected:
  ~Sides() = default;
};

/// Springs or edges between points.
class Links {
 public:
  /// The links of the two kinds.
  virtual const std::vector<std::pair<Index, Index>>& stretchLinks() const = 0;
  virtual const std::vector<std::pair<Index, Index>>& bendLinks() const = 0;
  /// Makes links and triangles those of this state, in models where they change.
  virtual void refreshDisplay(const State& /*state*/) const {}
  /// Largest stretch |l / l0 - 1| of any link between neighbours.
  virtual double maxStretch(const State& state) const = 0;
  /// Strain of each point for display: the largest |l / l0 - 1| of its links. (n), overwritten.
  virtual void computePointStrain(const State& state, std::vector<double>& strain) const = 0;

 protected:
  ~Links() = default;
};

/// Stress at the points.
class Stresses {
 public:
  /// Equivalent stress of von Mises of each point, Pa: (n), overwritten.
  virtual void computePointStress(const State& state, std::vector<double>& stress) const = 0;

 protected:
  ~Stresses() = default;
};

}  // namespace deformable_surface::model
