// Points so near to each other that they are one: twice the same scan, rounded otherwise.
#pragma once

#include "deformable_surface/cloud/clean.h"

namespace deformable_surface::cloud {

/// The distance of a typical point from the nearest one that is not almost the same: the median over a part of the points. m; 0
/// for fewer than two. O(n log n).
double findTypicalSpacing(const Points& points);

struct NearPoints {
  double spacing = 0.0;   // m, findTypicalSpacing(); 0 if no points are merged
  Index num_merged = 0;   // points that are left out
  double distance = 0.0;  // m, at most, of these from the points that stand for them
};

/// Merges points nearer to each other than a hundredth of the spacing, and than a hundredth of the distance to the points around
/// them, so that fine parts of a cloud stay. A heap of any size within a millionth of the spacing becomes one. Of a group, the
/// least position (by x, y, z) stays and the first normal that is one, at the place of the first point: as for points of equal
/// positions, the order of the input decides the numbers and the normal alone. A cloud without such points stays as it is.
/// The cloud keeps the tree. O(n log n).
NearPoints mergeNearPoints(CleanCloud& cloud);

}  // namespace deformable_surface::cloud
