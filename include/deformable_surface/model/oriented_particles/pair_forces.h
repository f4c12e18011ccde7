// The forces between a particle and its neighbours. This is the hot loop: four neighbours at a time, with a compiled version for
// every set of terms.
#pragma once

#include "deformable_surface/model/oriented_particles/neighbor_list.h"
#include "deformable_surface/model/oriented_particles/pair_potentials.h"

namespace deformable_surface::model {

/// Particles as the loop reads them.
struct PackedParticles {
  std::vector<double> places;   // (4 n) x, y, z in m and the strength of bonds, 0 .. 1, by temperature
  std::vector<double> normals;  // (4 n) unit, and 1 if the particle is smooth, else 0
  // (8 n) 1/m, at rest: xx, yy, zz, yz, xz, xy, 0, 0 in the world; empty: the rest shape is flat.
  std::vector<double> curvatures{};

  const double* place(Index i) const { return places.data() + 4 * static_cast<std::ptrdiff_t>(i); }
  const double* curvature(Index i) const { return curvatures.data() + 8 * static_cast<std::ptrdiff_t>(i); }
  const double* normal(Index i) const { return normals.data() + 4 * static_cast<std::ptrdiff_t>(i); }
};

/// Adds to forces (N) and torques (N m), (n x 3) each, those on particles begin .. end - 1. A particle gathers from its
/// neighbours in ascending order: the bits depend neither on threads nor on other entries of the lists.
///
/// With r = p_j - p_i, d = |r|, u = n.r for either normal, s = u_i + u_j, Q = |n_i - n_j|^2 the energy of a pair, both orders
/// summed, is
///   E = 2 phi(d) + psi_i (aP u_i^2 + aN Q + aC s^2) + psi_j (aP u_j^2 + aN Q + aC s^2)
/// [Szeliski 1991, eq. 5 to 8, 11]. The strength of the weaker particle's bonds multiplies psi and the attraction in phi: all of
/// it beyond its minimum, and its depth. The repulsion nearer than that stays, so that melted particles do not overlap.
/// psi is zero for pairs with a particle that is not smooth; psi_i = psi_j = psi(d), or [eq. 10]
/// exp(-(d^2 - u^2) / 2 a^2 - u^2 / 2 b^2) times the switch. Then
///   f_i = c_r r + c_i n_i + c_j n_j,  tau_i = (c_i r + 2 aN (psi_i + psi_j) (n_i - n_j)) x n_i,
///   c_k = 2 aP u_k psi_k + 2 aC s (psi_i + psi_j) + dE/dpsi_k dpsi_k/du_k,  c_r d = dE/dd.
/// These are minus the gradient of E; the printed appendix B is not.
///
/// With rest curvatures K (isotropic weighting only), in aP's terms u_i becomes u_i + r.K_i r / 2, u_j becomes u_j - r.K_j r / 2,
/// and in aN's n_i - n_j becomes q = n_i - n_j + (K_i + K_j) r / 2. Both vanish where the surface has those curvatures, up to
/// higher powers of them. K turns with its particle.
void gatherForces(const PairPotentials& pair, const NeighborList& lists, const PackedParticles& particles, Index begin, Index end,
                  Vec3* forces, Vec3* torques);

/// The energy of particles begin .. end - 1: half of E of each pair that they are in, J.
double gatherEnergy(const PairPotentials& pair, const NeighborList& lists, const PackedParticles& particles, Index begin,
                    Index end);

/// The same for pairs with a cut between them, which have no bond: of phi they keep the repulsion, so that the edges of a cut do
/// not enter each other.
void gatherContact(const PairPotentials& pair, const NeighborList& lists, const PackedParticles& particles, Index begin,
                   Index end, Vec3* forces);
double gatherContactEnergy(const PairPotentials& pair, const NeighborList& lists, const PackedParticles& particles, Index begin,
                           Index end);

/// The same for pairs that are kept apart because they are far from each other over the surface at rest. With c the smaller of
/// `range` (m) and the pair's own, E = stiffness (c - d)^2 for d < c: the force ends with zero there, so that layers that lie c
/// apart at rest stay so. In one place they part along the surface of the first. stiffness: N/m, >= 0.
struct ApartPotential {
  double stiffness = 0.0, range = 0.0;
};
void gatherApart(const ApartPotential& apart, const NeighborList& lists, const PackedParticles& particles, Index begin, Index end,
                 Vec3* forces);
double gatherApartEnergy(const ApartPotential& apart, const NeighborList& lists, const PackedParticles& particles, Index begin,
                         Index end);
/// How many such pairs of a particle repel.
Index countApart(const ApartPotential& apart, const NeighborList& lists, const PackedParticles& particles, Index i);

/// Bounds of the magnitudes of the stiffness that couples a pair's coordinates. X: positions, N/m; Y: a position with an
/// orientation, N; Z: orientations, N m, of one particle and of both together.
struct PairStiffness {
  double x = 0.0, y = 0.0, z = 0.0;
};
PairStiffness boundStiffness(const PairPotentials& pair, const PackedParticles& particles, Index i, Index j);
/// The same of a pair at a distance, m, with a cut between: N/m by positions, the only term.
double boundContactStiffness(const PairPotentials& pair, double distance);

}  // namespace deformable_surface::model
