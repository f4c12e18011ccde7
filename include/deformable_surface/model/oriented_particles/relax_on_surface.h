// Spreads the particles of a growing surface evenly between two passes. It is geometry, without the model's forces,
// so that nothing crumples, tears or flies off, whatever the material.
#pragma once

#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface::model {

/// In each sweep a movable particle moves
///   along its tangent plane, away from particles nearer than the spacing r0: by a quarter of the missing distance;
///   along its normal n, half of the way to where the co-circularity (eq. 8 of [Szeliski and Tonnesen 1991]) is least,
///     min over h of  sum_j w_j ((n + n_j) . (p_j - p - h n))^2,   w_j = exp(-|p_j - p|^2 / (2 r0^2)), as far as 2 r0,
/// and turns by half of the way to the mean of its neighbours' normals, each mirrored in the plane midway, as for
/// co-circular normals. Spheres, cylinders and planes stay as they are. Neighbours are particles that face the same way.
///
/// positions (n x 3) m, in place; orientations (n); fixed (n): 1 = neither moves nor turns. Parallel; the same bits for every
/// number of threads.
///
/// awake (n); null: all move. Before: 1 = moves, and wakes those within 2 r0. A particle also wakes when one so near moves in a
/// sweep by more than 0.003 of the spacing, or turns by as many radians. After: 1 = did so in the last sweep.
void relaxOnSurface(double spacing, Index sweeps, const std::vector<char>& fixed, Points& positions, Orientations& orientations,
                    std::vector<char>* awake = nullptr);

}  // namespace deformable_surface::model
