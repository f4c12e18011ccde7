// Subscribes to clouds through our own decoder instead of roscpp's. Apart from the decoder, which needs no topics.
#pragma once

#include "deformable_surface/ros/cloud_decoder.h"
#include "deformable_surface/ros/raw_message.h"

#include <boost/shared_ptr.hpp>
#include <ros/node_handle.h>

#include <functional>
#include <string>

namespace deformable_surface::node {

using BoundedCloud = RawMessage<sensor_msgs::PointCloud2>;

/// Subscribes to a PointCloud2 topic through the decoder. The callback gets refused clouds too, to report them.
inline ros::Subscriber subscribeCloud(ros::NodeHandle& node, const std::string& topic, std::uint32_t queue_size,
                                      const DecodeLimits& limits, const std::function<void(DecodedCloud&&)>& callback) {
  const auto decode = [limits, callback](const boost::shared_ptr<const BoundedCloud>& message) {
    callback(decodeCloud(message->bytes.data(), message->bytes.size(), limits));
  };
  return node.subscribe<BoundedCloud>(topic, queue_size, decode);
}

}  // namespace deformable_surface::node
