// Flying pixels: points that a depth camera produces at outlines, between the surface in front and the one behind, on neither.
// The rule needs the rows and columns of an organised cloud.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"

#include <vector>

namespace deformable_surface::cloud {

/// Marks the flying points of an organised cloud (n). In its row or column, such a point lies in a jump of depth: the next point
/// is nearer on one side and farther on the other, and the point continues neither side.
/// All is measured in w = 1 / distance from cloud.eye(). There a plane is affine along a line of pixels at any tilt, so that a
/// grazing surface continues itself. Noise and steps of depth grow with the square of the distance, and are constant in w. jump:
/// m at 1 m, hence the tolerance in w (1/m), > 0; a few times the noise, as extrapolated values are two to four times as noisy.
/// Two mixed pixels in a row are found at twice the jump. Wider slopes are taken for surface.
/// Throws InputError for a cloud with fewer than two rows or columns. O(n), parallel.
std::vector<char> findFlyingPixels(const PointCloud& cloud, double jump);

}  // namespace deformable_surface::cloud
