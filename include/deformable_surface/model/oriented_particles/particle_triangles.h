// Triangulates oriented particles, and measures the topology of the surface that they form. Particles have no connectivity:
// the triangles are computed from positions and normals for each display or measurement.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/model/deformable_model.h"

#include <functional>
#include <utility>

namespace deformable_surface::model {

/// Whether there is a cut between two particles. Empty: nothing is cut.
using AreApart = std::function<bool(Index, Index)>;

/// The surface triangulation of [Szeliski and Tonnesen 1991, sec. 5]: a triangle belongs to the surface if no other particle lies
/// within its smallest circumscribing sphere. That is the smallest sphere through its three corners, centre in the triangle's
/// plane, for obtuse triangles too: in the plane this is Delaunay's rule. (The smallest sphere that merely contains an obtuse
/// triangle would accept triangles that overlap.) Only particles that face the triangle's way are tested, so that
/// the two sides of a thin body do not disturb each other.
///
/// Further rules: no edge, and no sphere's radius, is longer than max_edge (m, > 0); the triangle's plane is at most 60 degrees
/// from the tangent plane of each corner; triangles overlap at no corner, seen along its normal: they form a manifold.
/// Among triangles that would overlap, those with an empty sphere come first, then those with particles on the sphere
/// (cocircular particles; the square of a grid gets one diagonal), then those that close a gap between others; ties in the
/// order of their corners.
///
/// positions, normals (n x 3, unit). Corners are counter-clockwise seen from the tip of the normals, the smallest index first;
/// all weights are 1; sorted by corners. Parallel but for the choice among overlapping triangles; O(n k^2) for k particles
/// within max_edge. Particles that are apart share no triangle, and do not count as within a sphere: the edges of a cut are edges
/// of the surface however near they lie. apart: called in parallel. Throws InputError.
std::vector<WeightedTriangle> triangulateParticles(const Points& positions, const Points& normals, double max_edge,
                                                   const AreApart& apart = {});

/// The links of particles in a plane curve ("chains", sec. 6): pairs (smaller index first, sorted) of at most max_edge (m) with
/// no other particle within the sphere that has the pair as diameter, under the same rules for normals: the same rule, one
/// dimension lower.
std::vector<std::pair<Index, Index>> linkChains(const Points& positions, const Points& normals, double max_edge,
                                                const AreApart& apart = {});

/// The topology of the surface. Particles without a triangle (link) count as isolated and in nothing else.
struct ParticleTopology {
  Index components = 0;
  Index boundary_loops = 0;        // of a surface: closed chains of boundary edges; of chains: their ends
  Index euler_characteristic = 0;  // V - E + F; of chains: V - E
  Index isolated = 0;
  bool closed = false;  // there are triangles (links), and no boundary
  Index genus = 0;      // handles, of a closed surface, summed over its components; else 0
};

/// triangles: a manifold, as triangulateParticles() makes them, of num_particles particles.
ParticleTopology measureTopology(Index num_particles, const std::vector<WeightedTriangle>& triangles);

/// The same for chains. A closed one has no genus and Euler characteristic 0.
ParticleTopology measureTopology(Index num_particles, const std::vector<std::pair<Index, Index>>& links);

}  // namespace deformable_surface::model
