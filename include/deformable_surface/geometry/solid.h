// The solids that tools are made of, as signed distances: how far a point is outside (or, negative, how deep inside), and in
// which direction it gets out.
#pragma once

#include "deformable_surface/geometry/signed_distance.h"
#include "deformable_surface/geometry/solid_params.h"

#include <limits>

namespace deformable_surface::geometry {

/// Exact signed distance of a point (m, in the solid's frame). Beyond the limit, m, outside the solid the result may be any value
/// above the limit, with any normal: distant points need no exact distance.
SignedDistance findSignedDistance(const Solid& solid, const Vec3& point, double limit = std::numeric_limits<double>::infinity());

/// Whether they are the same, number by number.
bool isSame(const Solid& a, const Solid& b);

/// The largest extent, m: the diameter of a sphere, the longest edge of a box, the larger of height and diameter of a cylinder or
/// cone, the longest edge of the box around a mesh; infinite for a plane.
double findLargestExtent(const Solid& solid);
/// The smallest, in the same way.
double findSmallestExtent(const Solid& solid);

}  // namespace deformable_surface::geometry
