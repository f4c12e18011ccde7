// Whether the points of a cloud lie in rows that are farther apart than the points in them. Neighbour lists take equal distances
// in all directions, so that such rows can come apart.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

/// How many times farther apart rows are than the points along them, on average; 1 where points lie in no rows, as in square
/// and triangular lattices and at random places. neighbors: nearest first, at least eight. Looks at a thousand points at most.
double findRowSpacing(const Points& points, const Lists& neighbors);

}  // namespace deformable_surface::cloud
