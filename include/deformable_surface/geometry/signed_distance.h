// The result of a signed distance query, shared by all kinds of solids.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::geometry {

struct SignedDistance {
  double distance;  // m; negative inside
  Vec3 normal;      // its gradient: unit, outward; one of them where several directions are equally short
};

}  // namespace deformable_surface::geometry
