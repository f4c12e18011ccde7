// Finds the rows that have changed between one cloud and the next: for remote viewers of a large surface of which a part moves.
#pragma once

#include "deformable_surface/DeformedUpdate.h"

#include <sensor_msgs/PointCloud2.h>

#include <cstdint>
#include <vector>

namespace deformable_surface::node {

class CloudUpdates {
 public:
  /// Fills the message with the rows of the cloud that differ from the cloud before, in any bit. It takes all rows if
  /// whole, if the layout has changed, or if there was no cloud before. Returns whether there is anything to send; only then it
  /// is counted.
  bool make(const sensor_msgs::PointCloud2ConstPtr& cloud, bool whole, DeformedUpdate& message);
  /// Forgets the cloud before: the next message has all rows.
  void forget() { last_.reset(); }

 private:
  sensor_msgs::PointCloud2ConstPtr last_;
  std::uint32_t sequence_ = 0;
  std::vector<std::vector<std::uint32_t>> found_;  // by block
};

}  // namespace deformable_surface::node
