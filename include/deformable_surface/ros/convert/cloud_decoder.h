// Decodes a PointCloud2, as bytes or as a message, into a point cloud. Every length is checked before it is used.
// The usual ways to read a PointCloud2 trust its numbers and read out of bounds. No other code in this package reads one.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/ros/convert/raw_message.h"

#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>

#include <cstddef>
#include <string>

namespace deformable_surface::node {

/// A cloud in its serialised form.
using BoundedCloud = RawMessage<sensor_msgs::PointCloud2>;

/// Upper limits of an accepted cloud.
struct DecodeLimits {
  Index max_points = 20000000;  // as input.max_points
  double max_coordinate = 1e6;  // m; beyond it a point counts as not finite, as in cloud::clean
};

/// A cloud, or the reason why it was refused.
struct DecodedCloud {
  std_msgs::Header header;   // frame_id without a leading slash
  cloud::PointCloud cloud;   // one point per input point; rows that are not finite or out of range are NaN
  Index num_not_finite = 0;  // such rows
  std::string problem;       // one sentence: what was found and what is accepted; empty if the cloud was accepted

  bool ok() const { return problem.empty(); }
};

/// Decodes the serialised form of a sensor_msgs/PointCloud2. x, y, z must be float32 or float64, in any layout and byte order;
/// normal_x, normal_y, normal_z are read as normals if all three are float32 or float64; all other fields but padding are kept.
/// Never throws on bad bytes and never allocates more than a small multiple of size. One pass over the points.
DecodedCloud decodeCloud(const std::uint8_t* bytes, std::size_t size, const DecodeLimits& limits);

/// The same checks on a message that is already in memory.
DecodedCloud decodeCloud(const sensor_msgs::PointCloud2& message, const DecodeLimits& limits);

}  // namespace deformable_surface::node
