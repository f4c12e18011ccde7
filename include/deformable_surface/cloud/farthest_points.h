// Reduces the points of a body, evenly: each next point is the farthest from those before. For surfaces, simplification.h keeps
// borders and rings; a body has neither.
#pragma once

#include "deformable_surface/cloud/simplification.h"

namespace deformable_surface::cloud {

/// The order of removal: farthest point sampling [Gonzalez 1985] in reverse. Distances are those in space to points that can be
/// reached from neighbour to neighbour, so that a point does not represent others across a gap. The first points are the
/// protected ones, or else the farthest from the middle, and one of every part. neighbors: of every point, nearest first, as far
/// as steps go. Diameters are twice the distance to earlier points. Stops at min_points. Ties by index. O(n k log n).
Simplification orderByDistance(const Points& positions, const Lists& neighbors, Index min_points,
                               const std::vector<Index>& protected_points);

}  // namespace deformable_surface::cloud
