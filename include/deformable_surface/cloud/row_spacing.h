// Whether the points of a cloud lie in rows that are farther apart than the points in them, or in small groups. Neighbour lists
// take equal distances in all directions, so that such rows can come apart.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

/// The most that RowSpacing::rows can be: neighbours along a row reach no farther.
constexpr double kFarthestRows = 5.0;

struct RowSpacing {
  double rows = 1.0;    // how many times farther apart rows are than the points along them, on average; 1: no rows
  double groups = 1.0;  // distance of the points of a group from each other over that from the next group; 1: no groups
};

/// Neither rows nor groups are found in square and triangular lattices and at random places. A group is of two to seven points,
/// as where two layers lie one above the other, or a scan is there twice with a shift. neighbors: nearest first, at least eight.
/// Looks at a thousand points at most.
RowSpacing findRowSpacing(const Points& points, const Lists& neighbors);

}  // namespace deformable_surface::cloud
