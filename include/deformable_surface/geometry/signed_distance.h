// The answer of every solid to the question where a point is. Apart from the solids, which are of several kinds.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::geometry {

struct SignedDistance {
  double distance;  // m; negative inside
  Vec3 normal;      // its gradient: unit, outward; where several directions are equally short, one of them
};

}  // namespace deformable_surface::geometry
