// What the solvers and the simulation know of a material: masses, forces, energy, stiffness and the bound for a stable step.
// Each model (mass_spring, ...) implements this, and solvers know no more of it. Where models differ in more than that, as in the
// life of particles, the simulation names them.
#pragma once

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/types.h"
#include "deformable_surface/contact/friction_anchors.h"
#include "deformable_surface/linear/block_sparse.h"

#include <limits>
#include <memory>
#include <utility>
#include <vector>

namespace deformable_surface::model {

constexpr Index kNoParent = -1;

/// What else an oriented particle carries along.
struct ParticleTraits {
  double temperature = 0.0;  // K above ambient; weakens its bonds
  Index id = 0;              // never used again, and never another's: the rank among the first ones, then by birth
  Index ancestor = 0;        // id of the one of the first ones that it comes from; its own if it is one
  Index parents[2] = {kNoParent, kNoParent};  // ids of those between which it was born
  double turn = 0.0;                   // rad, about its normal, of its x axis from that of its orientation; no force reads it
  Vec3 rest_curvature = Vec3::Zero();  // 1/m: xx, yy, xy in the orientation's frame, to which it is bent at rest
  bool is_smooth = true;               // false: no force that keeps the surface flat acts on or from it (a crease)
};

/// What moves: everything that a snapshot must hold of the simulation points. World frame.
struct State {
  Points positions;                                  // (n x 3) m
  Points velocities;                                 // (n x 3) m/s
  std::vector<contact::BodyAnchor> friction{};       // ascending by body, then point
  std::vector<contact::PairAnchor> self_friction{};  // ascending
  // Of models whose points are oriented, else empty:
  Orientations orientations{};           // (n) unit, from the point's frame to the world: its z axis is the normal
  Points spins{};                        // (n x 3) angular velocity, rad/s
  std::vector<ParticleTraits> traits{};  // (n)
  Index next_id = 0;                     // of the particle that is born next
  // Of solids that flow, else empty:
  std::vector<Mat3> plastic{};  // (n) F_p^-1, from where the surroundings of a point are at rest now to where they were at first
  double dissipated = 0.0;      // J, by what has flowed

  Index size() const { return static_cast<Index>(positions.size()); }
  /// The orientation of an oriented particle with its turn about the normal: the frame that shows the principal directions.
  Quaternion frame(Index i) const { return orientations[i] * Quaternion(Eigen::AngleAxisd(traits[i].turn, Vec3::UnitZ())); }
};

/// A triangle of the simulation points with the share of its area that it stands for: where several Delaunay triangulations are
/// possible (cocircular points), all of them are kept and share the area, so that weights times areas cover the surface once.
struct WeightedTriangle {
  Index corner[3];  // counter-clockwise seen from outside
  double weight;    // 0 .. 1
};

/// Which matrix a solver asks for. kPositive: each element's part projected to positive semidefinite, so that a descent direction
/// is certain. kExact: as it is, up to terms that a model says it leaves out; it converges faster where it happens to be
/// definite.
enum class Hessian { kPositive, kExact };

/// What a point is made of, in shares of the material that its model was made with; all positive.
struct PointMaterial {
  double stretching = 1.0;  // of E h
  double bending = 1.0;     // of D
  double density = 1.0;

  bool operator==(const PointMaterial& o) const {
    return stretching == o.stretching && bending == o.bending && density == o.density;
  }
};

/// Where a clamp ends beside one of the points that it holds.
struct ClampEdge {
  Index point;
  Vec3 place;  // m, on the surface at rest

  bool operator==(const ClampEdge& o) const { return point == o.point && place == o.place; }
};

class DeformableModel {
 public:
  virtual ~DeformableModel() = default;
  /// A model like this one, with scratch of its own, that another thread may use. Null: this model cannot be copied.
  virtual std::unique_ptr<DeformableModel> clone() const { return nullptr; }

  /// (n) kg; positive.
  virtual const std::vector<double>& masses() const = 0;

  /// Tells which points (n) do not move from now on, and where the patches end that clamp, so that a model can treat them as what
  /// they are; held points beside free ones that have no edge are hinges. edges: ascending points. Returns whether forces and
  /// stiffness are others than before.
  virtual bool setHeld(const std::vector<char>& /*held*/, const std::vector<ClampEdge>& /*edges*/) { return false; }

  /// From now on its points are made of these, (n): what lies between points takes the mean of theirs. Forces stay the gradient
  /// of the energy, and the stiffness keeps its pattern. Throws InputError, and changes nothing, if the model cannot.
  virtual void setMaterial(const std::vector<PointMaterial>& /*materials*/) {
    throw InputError("material: found values that differ from those the model was made with; accepted: those, for this model");
  }

  /// Adds the internal forces, elastic and viscous, in newtons: forces (n x 3). The elastic part is minus the gradient of
  /// elasticEnergy(). Points with equal velocity feel no viscous force.
  virtual void addForces(const State& state, Points& forces) const = 0;

  /// False only if addForces() never looks at the velocities: the same positions then give the same forces.
  virtual bool forcesReadVelocities() const { return true; }

  /// True if some of the elastic forces may bear a longer step than the others. addForces() is then addFastForces() and after it
  /// addSlowForces(), bit for bit; the slow ones never read velocities.
  virtual bool hasSlowForces() const { return false; }
  virtual void addFastForces(const State& state, Points& forces) const { addForces(state, forces); }
  virtual void addSlowForces(const State& /*state*/, Points& /*forces*/) const {}
  /// Upper bound of the largest eigenvalue of M^-1 K, with K their part of addStiffness() with Hessian::kPositive, 1/s^2.
  virtual double boundSlowRate(const State& /*state*/) const { return 0.0; }

  /// True if the points carry orientations, which torques turn: State then has the arrays for it.
  virtual bool isOriented() const { return false; }
  /// (n) kg m^2, positive: moments of inertia, the same about every axis. Only of oriented points.
  virtual const std::vector<double>& inertias() const { return masses(); }
  /// Adds forces as addForces() does, and the torques in N m: torques (n x 3).
  virtual void addForcesAndTorques(const State& state, Points& forces, Points& /*torques*/) const { addForces(state, forces); }

  /// Fills what is beyond positions and velocities of a state at rest, which has as many points as at the beginning.
  virtual void beginAtRest(State& /*state*/) {}
  /// The state may hold other points than before (some born, some gone, a snapshot restored): masses follow.
  virtual void adopt(const State& /*state*/) {}
  /// Makes links and triangles those of this state, where they change.
  virtual void refreshDisplay(const State& /*state*/) const {}

  /// Of a model whose elements are those that its state makes: from now on it is taken in parts as this state has them, and these
  /// hold while no point moves farther than maxPartMotion(). Returns whether it is such a model.
  virtual bool followPartners(const State& /*state*/) { return false; }
  /// m; infinite of other models.
  virtual double maxPartMotion() const { return std::numeric_limits<double>::infinity(); }
  /// Marks (n, 1) all points that share an element with one of these: those whose positions the forces on them depend on. False:
  /// the model cannot be taken in parts, and nothing is marked.
  virtual bool markPartners(const std::vector<Index>& /*points*/, std::vector<char>& /*marked*/) const { return false; }
  /// A model of a part of the points.
  struct Part {
    std::unique_ptr<DeformableModel> model;  // null: it cannot be taken in parts
    std::vector<Index> points;               // ascending: which of the whole each of its points is
  };
  /// The elements that touch a wanted point, wanted (n), with all points of theirs. On wanted points its forces are those of the
  /// whole model, bit for bit (to rounding, of solids and of links without length); it is open, and its points are held as now
  /// for good.
  virtual Part makePart(const std::vector<char>& /*wanted*/) const { return {}; }

  /// The largest step, s, with which explicit integrators are stable at this state; 0: to be measured from the stiffness.
  virtual double findStableStep(const State& /*state*/) const { return 0.0; }

  /// Elastic energy in joules; zero in the rest state.
  virtual double elasticEnergy(const State& state) const = 0;

  /// Size of the terms of which elasticEnergy() is the small difference, J: what its rounding is in proportion to. 0: it is no
  /// difference.
  virtual double energyScale() const { return 0.0; }

  /// Takes from forces (n x 3) on the points what these cannot follow, as they stay in a plane.
  virtual void confine(Points& /*forces*/) const {}

  /// False: the stiffness is not known, and there is no implicit method.
  virtual bool hasStiffness() const { return true; }
  /// Adds the Hessian of the elastic energy, N/m. step: the time over which a solver differentiates velocities; the viscous
  /// forces add their damping matrix divided by it (0 = statics, no viscous part).
  virtual void addStiffness(const State& state, double step, Hessian hessian, BlockSparse& stiffness) const = 0;

  /// True: the stiffness is known by its products with vectors alone, as its matrix would be too full; addStiffness() adds
  /// nothing.
  virtual bool hasStiffnessProducts() const { return false; }
  /// Remembers, as scratch, the Hessian of the elastic energy at a state: products are with it until the next call.
  virtual void prepareStiffness(const State& /*state*/, Hessian /*hessian*/) const {}
  /// Adds K v: v (n x 3) m, product (n x 3) N.
  virtual void addStiffnessProduct(const Points& /*v*/, Points& /*product*/) const {}
  /// A spring with the same stiffness in every direction.
  struct Coupling {
    Index i, j;
    double stiffness;  // N/m
  };
  /// Springs between near points that together resist much as the stiffness does, fixed at rest: a solver's guess of what lies
  /// behind the products. Each pair once, i < j.
  virtual const std::vector<Coupling>& couplings() const {
    static const std::vector<Coupling> none;
    return none;
  }

  /// Of a surface, springs between near points, some of them negative, that together resist much as the stiffness at a state
  /// does: `along` what moves in the surface, fixed at rest, and `across` what moves out of it. Each pair once, i < j, one of two
  /// sets of pairs until the model is changed; overwritten, no motion gains energy from them. support: where there is
  /// tension, this share of its mean is added everywhere, against steps into folds where next to nothing resists them, and more
  /// where bending is left out for being weak. False: none are known.
  virtual bool knowsCouplings() const { return false; }
  virtual bool findCouplings(const State& /*state*/, double /*support*/, std::vector<Coupling>& /*along*/,
                             std::vector<Coupling>& /*across*/) const {
    return false;
  }

  /// The part of the Hessian that couples all points, c v v^T (a volume that is kept): returns c >= 0 and, if it is not zero,
  /// overwrites v (n x 3); c |v|^2 is in N/m.
  virtual double rankOneStiffness(const State& /*state*/, Points& /*v*/) const { return 0.0; }

  /// Upper bounds, per point, of the sums of the magnitudes of stiffness at rest (N/m) and of damping (N s/m) of its row: what
  /// Gershgorin's theorem needs. (n) each, added to.
  virtual void addRowBounds(const State& state, std::vector<double>& stiffness, std::vector<double>& damping) const = 0;

  /// Area vector of each point, m^2: outward normal times its share of the current area. (n x 3), overwritten.
  virtual void computeAreaVectors(const State& state, Points& area_vectors) const = 0;

  /// True if the surface has no boundary.
  virtual bool isClosed() const = 0;
  /// Volume enclosed by a closed surface, m^3, and its gradient by the positions, m^2, which sums to zero exactly: (n x 3),
  /// overwritten.
  virtual double enclosedVolume(const State& state) const = 0;
  virtual void computeVolumeGradient(const State& state, Points& gradient) const = 0;

  /// Largest stretch |l / l0 - 1| of any link between neighbours.
  virtual double maxStretch(const State& state) const = 0;

  /// Strain of each point for display: the largest |l / l0 - 1| of its links. (n), overwritten.
  virtual void computePointStrain(const State& state, std::vector<double>& strain) const = 0;

  /// Equivalent stress of von Mises of each point, Pa: (n), overwritten. False, and nothing done, of models that know no stress.
  virtual bool computePointStress(const State& /*state*/, std::vector<double>& /*stress*/) const { return false; }

  /// The links (springs, edges) of the two kinds, for display and counting.
  virtual const std::vector<std::pair<Index, Index>>& stretchLinks() const = 0;
  virtual const std::vector<std::pair<Index, Index>>& bendLinks() const = 0;

  /// The triangles of the surface, for display, area and volume.
  virtual const std::vector<WeightedTriangle>& triangles() const = 0;
};

}  // namespace deformable_surface::model
