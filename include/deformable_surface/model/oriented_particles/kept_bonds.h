// Bonds with a rest shape between particles that are neighbours at rest (`bonds: kept`). Not in [Szeliski 1991]: there all
// particles within reach bind each other, and a sheet that bends easily crumples.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/material_params.h"
#include "deformable_surface/model/oriented_particles/oriented_particles_params.h"
#include "deformable_surface/model/oriented_particles/pair_forces.h"
#include "deformable_surface/model/oriented_particles/particle_cuts.h"

#include <utility>
#include <vector>

namespace deformable_surface::model {

/// What is known of the bonds at rest. Particles are named by their ids, those of the initial state.
///
/// Along a bond with r = p_j - p_i, u_i = n_i.r, u_j = n_j.r, length l and rest values marked by 0
///   e = |r| / l - 1,   c = (u_j - u_i - c0) / l^2,   s = (u_i + u_j) / 2 - s0
/// are the strain, the change of curvature and the shear. Three bonds make a triangle of area A. Its e are the strains along
/// three directions and so give the strain tensor, its c the curvature tensor:
///   E = sum over triangles A/2 (e.M e + c.B c) + sum over bonds S/2 s^2,   M = T^-t C T^-1
/// T: rows (cos^2, sin^2, cos sin) of the directions. C: of plane stress, for M with E h and Poisson's ratio, for B with the
/// bending rigidity and Poisson's ratio of bending. So every constant strain and curvature has the energy of the plate, on any
/// triangles. S = 12 D (1 - nu^2) sum A / l^4: with it a beam of one bond deflects by cubic functions exactly [MacNeal 1978]. The
/// shear stiffness of the material would lock.
struct KeptBonds {
  struct Bond {
    Index i, j;            // i < j at rest
    double length;         // m, l
    double shearing;       // N/m, S
    double curve, height;  // m, c0 and s0
  };
  struct Triangle {
    Index bond[3];  // edges 01, 12, 20 of the corners
    WeightedTriangle corners;
    Mat3 stretching, bending;  // A M, J; A B, J m^2
  };
  /// A pair without a bond that is nearer at rest than such pairs repel.
  struct Close {
    Index i, j;
    double distance;  // m
  };
  std::vector<Bond> bonds;
  std::vector<Triangle> triangles;
  std::vector<Close> close;
  std::vector<double> areas;  // (n) m^2
  double inertia_by_mass;     // m^2, with which a particle turns back no faster than it moves back; at least h^2 / 12

  /// From the state at rest of the initial particles.
  KeptBonds(const State& rest, const std::vector<WeightedTriangle>& corners, std::vector<double> areas,
            const MaterialParams& material, const OrientedParticlesParams& params);

  /// Memory beside the object itself.
  std::size_t bytes() const;
};

/// The bonds that a population still has, as its forces read them. A bond without a whole triangle is none.
class PresentBonds {
 public:
  /// O(n + bonds).
  void update(const KeptBonds& kept, const std::vector<ParticleTraits>& traits, const ParticleCuts& cuts);

  const std::vector<KeptBonds::Bond>& bonds() const { return bonds_; }
  const std::vector<WeightedTriangle>& triangles() const { return triangles_; }
  std::size_t bytes() const;
  bool areBound(Index i, Index j) const;
  /// m, at rest, between two particles that have lost their bond or were close without; infinite for others.
  double restDistance(Index i, Index j) const;
  /// The particles bound to i.
  const Index* begin(Index i) const { return others_.data() + begins_[i]; }
  const Index* end(Index i) const { return others_.data() + begins_[i + 1]; }

  /// Adds to forces (N) and torques (N m), (n x 3) each. Parallel.
  void addForces(const PackedParticles& particles, Points& forces, Points& torques) const;
  /// J. Parallel.
  double findEnergy(const PackedParticles& particles) const;
  /// Adds to bounds (n), N/m: the stiffness K is at most the diagonal matrix of the bounds, times inertia_by_mass (m^2) for
  /// orientations. If that of each triangle t alone is at most r_t times the identity of its corners, then the bound of a
  /// particle is the sum of r_t over its triangles. K of a triangle is G^T S G, with the gradients G of its three e, c and s and
  /// their stiffness S, and slopes of energy times second derivatives. The eigenvalues of the first are those of S G G^T; a bound
  /// from mean and deviation of their squares [Wolkowicz 1980] stands for the largest. Norms over all three corners bound the
  /// rest, without turns about normals, which move nothing. What softens is left out, but for stretched bonds along themselves.
  /// Parallel.
  void addRowBounds(const PackedParticles& particles, double inertia_by_mass, std::vector<double>& bounds) const;

  /// Four triangles as the loops read them; lengths and strains are those of the edges from corner to corner.
  struct FourTriangles {
    Index corner[3][4];
    double length[3][4], curve[3][4], height[3][4];  // m
    double shearing[3][4];                           // N/m: a bond shares S among its triangles
    // N/m: A M and A B for l e and l^2 c in place of e and c: 00, 11, 22, 12, 02, 01; zero: there is no triangle.
    double stretching[6][4], bending[6][4];
  };

 private:
  void arrange(const std::vector<KeptBonds::Triangle>& triangles, const std::vector<double>& num_sides);

  std::vector<KeptBonds::Bond> bonds_;  // by present numbers
  std::vector<WeightedTriangle> triangles_;
  std::vector<FourTriangles> fours_;
  std::vector<KeptBonds::Close> unbound_;                 // those that have lost their bond too; by i, then j
  std::vector<Index> begins_, others_;                    // of each particle: the others
  std::vector<Index> corner_begins_, corners_;            // of each particle: 3 t + corner
  mutable std::vector<double> pushes_, triangle_bounds_;  // scratch: 20 of each triangle; one
};

}  // namespace deformable_surface::model
