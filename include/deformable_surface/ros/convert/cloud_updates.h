// What has changed from one cloud to the next, row by row: for those who look from afar at a large surface of which a part moves.
#pragma once

#include "deformable_surface/DeformedUpdate.h"

#include <sensor_msgs/PointCloud2.h>

#include <cstdint>
#include <vector>

namespace deformable_surface::node {

class CloudUpdates {
 public:
  /// Fills the message with the rows of the cloud that differ from those of the cloud before, in any bit, or with all of them: if
  /// whole, if the layout is another, or if there was none before. Returns whether there is anything to send; only then it is
  /// counted.
  bool make(const sensor_msgs::PointCloud2ConstPtr& cloud, bool whole, DeformedUpdate& message);
  /// The cloud before is let go of, so that the next message is whole.
  void forget() { last_.reset(); }

 private:
  sensor_msgs::PointCloud2ConstPtr last_;
  std::uint32_t sequence_ = 0;
  std::vector<std::vector<std::uint32_t>> found_;  // by block
};

}  // namespace deformable_surface::node
