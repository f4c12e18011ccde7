// Points inside a closed surface that is given by points alone.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

/// A surface as seen from a distance: places (m x 3) m, and the outward area vectors (m x 3) m^2 of the surface around each.
struct SurfaceDipoles {
  Points places, areas;
};

/// Sums points (n x 3) with unit outward normals and areas (n) m^2 by owner (n) in 0 .. count - 1.
SurfaceDipoles gatherDipoles(const Points& positions, const Points& normals, const std::vector<double>& areas,
                             const std::vector<Index>& owner, Index count);

/// The generalised winding number [Jacobson et al. 2013] by the dipoles of the points [Barill et al. 2018, eq. 8],
///   w(q) = sum_i a_i . (x_i - q) / (4 pi |x_i - q|^3):
/// one inside a closed surface, zero outside, between where it is open. Inaccurate nearer to the surface than its dipoles are to
/// each other. O(m).
double findWindingNumber(const SurfaceDipoles& surface, const Vec3& q);

struct Interior {
  Points points;          // (p x 3) a cubic lattice, m
  double doubtful = 0.0;  // share of the places found where, clearly off the surface, the winding number is neither zero nor one
};

/// Points of a cubic lattice that are inside, whichever side the normals are on, and not nearer to the points of the surface
/// (n x 3) than a fraction of the spacing (m). Parallel; O(m) for every lattice point of the box around the surface.
Interior fillSurface(const SurfaceDipoles& dipoles, const Points& surface, double spacing);

}  // namespace deformable_surface::cloud
