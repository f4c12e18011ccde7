// What is written and published of a simulation besides the clouds of encode.h: the surface as a cloud for files, and the
// statistics message. The node and `simulate` share it.
#pragma once

#include "deformable_surface/Statistics.h"
#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/simulation/simulation.h"

namespace deformable_surface::node {

/// The surface with the input's extra fields, width and height (a row if points were inserted), for io::writePointFile().
cloud::PointCloud makeOutputCloud(const simulation::Surface& surface, const cloud::PointCloud& input);

/// Fills all but the header.
void encodeStatistics(const simulation::Statistics& statistics, Statistics& message);

}  // namespace deformable_surface::node
