// Points that a depth camera makes at the outline of things: between the surface in front and the one behind, on neither. Apart
// from what removes points, because this rule knows the rows and columns of a cloud and nothing else does.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"

#include <vector>

namespace deformable_surface::cloud {

/// Marks the points of an organised cloud that fly (n): in its row or column such a point hangs in a jump of depth, the next one
/// nearer on one side and farther on the other, and continues neither side.
/// All is measured in w = 1 / distance from cloud.eye(). There a plane is affine along a line of pixels, however much it is
/// tilted, so that a grazing surface continues itself; and noise and steps of depth, which grow with the square of the distance,
/// are the same everywhere. jump: m at 1 m, and so the tolerance in w (1/m), > 0; some times the noise, as what is extrapolated
/// is two to four times as noisy. Two mixed pixels in a row are found at twice the jump; wider slopes are taken for
/// surface.
/// Throws InputError for a cloud with fewer than two rows or columns. O(n), parallel.
std::vector<char> findFlyingPixels(const PointCloud& cloud, double jump);

}  // namespace deformable_surface::cloud
