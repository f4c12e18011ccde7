// Helpers shared by the parts of the mass-spring model: which elements touch a point, and a direction for degenerate elements.
#pragma once

#include "deformable_surface/base/types.h"

#include <utility>

namespace deformable_surface::model {

/// Groups (point, item) pairs by point; items of a point keep their order in the list.
Lists groupByPoint(Index num_points, const std::vector<std::pair<Index, Index>>& point_items);

/// A unit vector that depends on the two indices only. It breaks the symmetry of coincident points always in the same way.
Vec3 fixedDirection(Index i, Index j);

}  // namespace deformable_surface::model
