// The solids that tools are made of, as signed distances: how far a point is outside (or, negative, how deep inside), and in which
// direction it gets out.
#pragma once

#include "deformable_surface/geometry/solid_params.h"

namespace deformable_surface::geometry {

struct SignedDistance {
  double distance;                // m; negative inside
  Vec3 normal;                    // its gradient: unit, outward; where several directions are equally short, one of them
};

/// Exact signed distance of a point (m, in the solid's frame).
SignedDistance findSignedDistance(const Solid& solid, const Vec3& point);

}  // namespace deformable_surface::geometry
