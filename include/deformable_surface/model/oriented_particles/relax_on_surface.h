// How the particles of a surface that grows come to lie evenly on it between two passes. Apart from the forces of the model: it
// is geometry, so that nothing crumples, tears or flies off, whatever the material.
#pragma once

#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface::model {

/// In each sweep a particle that may move goes
///   along its tangent plane, away from those nearer than the spacing r0: by a quarter of what they lack;
///   along its normal n, by half of the way to where the co-circularity (eq. 8 of [Szeliski and Tonnesen 1991]) is least,
///     min over h of  sum_j w_j ((n + n_j) . (p_j - p - h n))^2,   w_j = exp(-|p_j - p|^2 / (2 r0^2)), as far as 2 r0,
/// and turns by half of the way to the mean of the normals that mirror those of its neighbours in the plane midway, which
/// co-circular normals do. Spheres, cylinders and planes are at rest. Those nearby: who faces the same way.
///
/// positions (n x 3) m, in place; orientations (n); fixed (n): 1 = neither moves nor turns. Parallel; the same bits for every
/// number of threads.
void relaxOnSurface(double spacing, Index sweeps, const std::vector<char>& fixed, Points& positions, Orientations& orientations);

}  // namespace deformable_surface::model
