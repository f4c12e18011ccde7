// Whether a cloud has come again. A file of its own, because clouds are used everywhere and compared in one place.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"

namespace deformable_surface::cloud {

/// Whether all of one is as in the other, bit for bit; holes are equal to holes.
bool areEqual(const PointCloud& a, const PointCloud& b);

}  // namespace deformable_surface::cloud
