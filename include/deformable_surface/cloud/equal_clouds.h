// Compares two clouds: whether the same cloud has been sent again.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"

namespace deformable_surface::cloud {

/// Whether both clouds are equal in every part, bit for bit. Holes equal holes.
bool areEqual(const PointCloud& a, const PointCloud& b);

}  // namespace deformable_surface::cloud
