// The plane of a point and points around it. Private; defined in normals.cpp.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

struct Plane {
  Vec3 normal;
  double thickness = 0.0;  // least variance over the middle one
  double width = 0.0;      // middle variance over the largest
};

/// The plane of least variance through point i and those of a list. InputError if they are not finite.
Plane fitPlane(const Points& positions, Index i, const Index* first, const Index* last);

}  // namespace deformable_surface::cloud
