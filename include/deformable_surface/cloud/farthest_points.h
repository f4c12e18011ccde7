// Fewer points that still fill a body evenly: the order in which every next point is the farthest from those before. For surfaces
// simplification.h keeps borders and rings; a body has neither.
#pragma once

#include "deformable_surface/cloud/simplification.h"

namespace deformable_surface::cloud {

/// The order of removal, the reverse of farthest point sampling [Gonzalez 1985] with the distance in space to those points that
/// can be reached from point to neighbour (so that a point does not stand for others across a gap): the first are the protected
/// points, or else the farthest from the middle, and one of every part. neighbors: of every point, nearest first, as far as
/// steps go. Its diameters are twice the distance to those before. Down to min_points. Ties by index. O(n k log n).
Simplification orderByDistance(const Points& positions, const Lists& neighbors, Index min_points,
                               const std::vector<Index>& protected_points);

}  // namespace deformable_surface::cloud
