// The oriented particles of [Szeliski 1991]: small elements of surface held together by potentials between pairs, without
// a mesh. The surface can tear, merge and grow.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/oriented_particles/kept_bonds.h"
#include "deformable_surface/model/oriented_particles/lattice.h"
#include "deformable_surface/model/oriented_particles/neighbor_list.h"
#include "deformable_surface/model/oriented_particles/pair_forces.h"

#include <cmath>
#include <functional>
#include <memory>
#include <optional>

namespace deformable_surface::model {

/// A state of this model holds orientations, spins and traits of every particle.
class OrientedParticles : public DeformableModel,
                          public OrientedPoints,
                          public InnerState,
                          public Partition,
                          public Sides,
                          public Links {
 public:
  /// rest, normals: (n x 3), unit, of the particles at first; they are flat at rest (but see setRest()). spacing: m, of
  /// the cloud, for params.spacing: auto. apart: as in NeighborList; such particles and their descendants have no
  /// bonds, and repel each other below half a spacing (but see keepLayers()). Throws InputError if a surface of these potentials
  /// would collapse.
  OrientedParticles(const Points& rest, const Points& normals, double spacing, const MaterialParams& material,
                    const OrientedParticlesParams& params, Lists apart = {});

  /// The spacing, m, of the hexagonal lattice of n particles on an area, m^2: each has sqrt(3) / 2 of its square.
  static double findSpacing(double area, Index n);

  std::unique_ptr<DeformableModel> clone() const override { return std::make_unique<OrientedParticles>(*this); }
  const std::vector<double>& masses() const override { return masses_; }
  const OrientedPoints* orientedPoints() const override { return this; }
  const Partition* partition() const override { return this; }
  const Sides* sides() const override { return this; }
  const Links* links() const override { return this; }
  InnerState* innerState() override { return this; }
  const std::vector<double>& inertias() const override { return inertias_; }
  double rotationalDamping(double motion) const override { return params_.rotational_damping.valueOr(motion); }
  bool forcesReadVelocities() const override { return false; }
  void addForces(const State& state, Points& forces) const override;
  void addForcesAndTorques(const State& state, Points& forces, Points& torques) const override;

  void beginAtRest(State& state) override;
  /// From now on particles start with the normals and the rest curvatures of this state.
  void setRest(const State& state);
  /// Particles that are kept apart and face each other or away from each other in this state of the initial particles, like the
  /// sides of a thin body, repel only where they come nearer than they are.
  void keepLayers(const State& state);
  /// For bonds: kept. The state of the initial particles is their rest shape; triangles: between neighbours; areas: (n) m^2, from
  /// which their masses come. From now on no other particles bind each other.
  void keepBonds(const State& state, const std::vector<WeightedTriangle>& triangles, std::vector<double> areas);
  bool hasKeptBonds() const { return kept_ != nullptr; }
  /// Whether a kept bond is longer than bonds can be. Parallel.
  bool isAnyStretched(const State& state) const;
  /// The kept bonds (ids) that are longer than bonds can be or have melted in this state.
  ParticleCuts::Pairs findBroken(const State& state) const;
  /// The kept bonds (ids) for which isCrossed(i, j) holds, i and j the numbers of present particles.
  ParticleCuts::Pairs findCrossed(const State& state, const std::function<bool(Index, Index)>& is_crossed) const;
  /// Takes the present bending of every smooth particle as its rest shape, estimated from its neighbours, up to a radian each.
  void keepShape(State& state) const;
  /// Replaces each rest curvature by the mean over the particle and the neighbours that face the same way, moved along the
  /// surface; repeated `times` times. This removes noise and the effect of places where a lattice cannot be regular. Spheres
  /// and cylinders keep their curvature.
  void smoothShape(Index times, State& state) const;
  /// The spacing, m, with which the surface as it is would have no tension: sum of d phi'(d) over all pairs = 0. This condition
  /// also gives a flat lattice its spacing. The spacing of lattice() if there is none within the reach of the lists.
  double findSpacingWithoutTension(const State& state) const;
  /// From now on the lattice has this spacing, m. The caller must adopt the state again.
  void setSpacing(double spacing);
  /// The edge, m, of the equilateral triangle with the mean area of the triangles between the particles; 0 if there are none.
  double measureSpacing(const State& state) const;
  /// The mean number of bonds of a particle, and that inside a flat lattice (a chain in mode plane).
  double meanBonds(const State& state) const;
  double latticeBonds() const;
  /// Those particles (n) become 1 around which a gap of at least this angle, rad, opens: seen along the normal, no other that
  /// faces the same way within 90 degrees is in it and in reach of a bond. Only those that are 1 before are looked at; all become
  /// 0 if there are no bonds at these positions. O(k^2) for one with k others in reach.
  void keepOpen(const State& state, double angle, std::vector<char>& is_open) const;
  /// From now on no force depends on orientations, until the spacing is set.
  void leaveOnlyAttraction();
  /// The spacing of the parameters, or of the cloud.
  double statedSpacing() const { return stated_spacing_; }
  void adopt(const State& state) override;
  /// From now on there are these cuts. The state whose particles they name is the next one that the model is asked about.
  void setCuts(const ParticleCuts& cuts);
  const ParticleCuts& cuts() const { return cuts_; }
  /// How far cuts look for pairs, m.
  ParticleCuts::Lengths cutLengths() const;
  /// The cuts after particles have moved to this state; the same if nothing has changed, or positions are not finite.
  ParticleCuts followCuts(const State& state) const;
  void refreshDisplay(const State& state) const override;
  /// Elements are the pairs within reach of the lists in the followed state.
  bool followPartners(const State& state) override;
  double maxPartMotion() const override;
  bool markPartners(const std::vector<Index>& points, std::vector<char>& marked) const override;
  /// Links between the points that share elements, so that parts of them are parts that forces connect.
  std::vector<std::pair<Index, Index>> linkPartners() const;
  /// A part of the present particles, which must have distinct ids. It has no births and starts no state.
  Part makePart(const std::vector<char>& wanted) const override;
  /// From a bound of the stiffness at the state, including orientations: Gershgorin's, or that of kept bonds. A function of the
  /// state alone.
  double findStableStep(const State& state) const override;
  /// Relative to a flat sheet of as many particles without edges: an edge costs the energy of its missing bonds.
  double elasticEnergy(const State& state) const override;
  double energyScale() const override { return std::abs(lattice_.energy_per_particle) * static_cast<double>(masses_.size()); }

  /// There is no stiffness matrix for implicit methods: bonds form and break with distance.
  void addRowBounds(const State& state, std::vector<double>& stiffness, std::vector<double>& damping) const override;
  /// The normal times the area per particle of the flat lattice.
  void computeAreaVectors(const State& state, Points& area_vectors) const override;
  bool isClosed() const override { return false; }
  /// Sum of x.A / 3 over the particles' area vectors. Meaningful only if they close a surface.
  double enclosedVolume(const State& state) const override;
  void computeVolumeGradient(const State& state, Points& gradient) const override;
  double maxStretch(const State& state) const override;
  void computePointStrain(const State& state, std::vector<double>& strain) const override;
  /// Like the triangles, of the last refreshDisplay(), none after adopt(); with kept bonds, of the state asked about last.
  const std::vector<std::pair<Index, Index>>& stretchLinks() const override { return links_; }
  const std::vector<std::pair<Index, Index>>& bendLinks() const override { return no_links_; }
  const std::vector<WeightedTriangle>& triangles() const override { return triangles_; }

  const Lattice& lattice() const { return lattice_; }
  const OrientedParticlesParams& params() const { return params_; }
  /// Changes beside the motion in a time, s, without moving anything: x axes turn towards a principal direction if params.spin
  /// is set [Szeliski 1991, eq. 14 or 15], without inertia, exactly as on a surface that stands still for that time.
  void turnAxes(double time, State& state) const;
  /// Whether rest curvatures are used. New particles then take those of their parents.
  bool isBent() const { return is_bent_; }
  /// Plasticity: rest curvatures change where bending exceeds params.yield_curvature. Returns whether any did.
  bool flow(State& state) const;
  /// The temperature, K, after a time, s: it falls exponentially.
  double coolDown(double temperature, double time) const;
  /// Memory of the lists and copies.
  std::size_t bytes() const;

 private:
  OrientedParticles(const OrientedParticles& whole, std::size_t count);  // a part with `count` particles
  bool prepare(const State& state) const;
  ApartPotential apartPotential() const;
  double areaOf(const ParticleTraits& traits) const;
  double mostStretch() const;
  void listStrangers() const;
  template <class Visit>
  void forEachPartner(Index i, const Visit& visit) const;
  template <class Take>
  void forEachStranger(Index i, const Take& take) const;
  double boundKeptFrequency() const;
  void addKeptBounds(double inertia_by_mass, std::vector<double>& bounds) const;
  std::optional<Vec3> fitCurvature(const State& state, Index i) const;
  template <class Take>
  void forEachNear(Index i, double distance, const Take& take) const;
  template <class Take>
  void forEachParted(Index i, const Take& take) const;
  template <class Add>
  void addStiffness(Index begin, Index end, const Add& add) const;

  const OrientedParticlesParams params_;
  const MaterialParams material_;
  const double stated_spacing_;  // m
  Lattice lattice_;
  double mass_;  // kg, of every particle
  Points normals_, rest_curvatures_;
  ParticleCuts cuts_;
  std::shared_ptr<const KeptBonds> kept_;  // null: all particles in reach bind each other
  bool is_bent_;                           // some particle is bent at rest, or may come to be
  std::vector<double> masses_, inertias_;
  // Display.
  mutable std::vector<std::pair<Index, Index>> links_;
  std::vector<std::pair<Index, Index>> no_links_;
  mutable std::vector<WeightedTriangle> triangles_;
  // Scratch.
  mutable PresentBonds bonds_;
  mutable bool has_bonds_ = false;  // they are those of the population
  mutable NeighborList lists_;
  mutable std::vector<Index> strangers_, stranger_begins_;  // of each particle: those near it without a bond, with kept bonds
  mutable std::vector<Index> touching_, touch_numbers_, touch_begins_;  // those nearer than strangers repel, and of each: numbers
  mutable std::vector<std::pair<Index, double>> touches_;               // 1/s^2
  mutable std::vector<double> weights_, products_;
  mutable Index strangers_of_ = 0;  // the number of rebuilds of the lists that they are of
  NeighborList partners_;           // for parts of the surface
  bool has_partners_ = true;        // false: unknown, and all are partners
  mutable PackedParticles packed_;
  mutable Points torques_;
  mutable std::vector<double> strain_, row_maxima_, row_bounds_;
  mutable std::vector<char> has_flowed_;
  mutable ParticleCuts::Scratch cut_scratch_;
};

}  // namespace deformable_surface::model
