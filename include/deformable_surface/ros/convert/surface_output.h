// Outputs of a simulation besides the clouds of encode.h: the surface as a cloud for files, and the
// statistics message. The node and `simulate` share it.
#pragma once

#include "deformable_surface/Statistics.h"
#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/simulation/simulation.h"

#include <ros/time.h>

#include <cstdint>
#include <string>

namespace deformable_surface::node {

/// The surface with the input's extra fields, width and height (a row if points were inserted), for io::writePointFile().
cloud::PointCloud makeOutputCloud(const simulation::Surface& surface, const cloud::PointCloud& input);

/// The cloud that a surface was made from.
struct CloudId {
  std::uint32_t number = 0;  // counts the clouds that became a surface, from 1
  ros::Time stamp;
  std::string frame;
};

/// Fills all but the header.
void encodeStatistics(const simulation::Statistics& statistics, const CloudId& cloud, Statistics& message);

}  // namespace deformable_surface::node
