// A message type that talks to publishers of sensor_msgs/PointCloud2 but keeps the bytes as they came, for our own decoder, so
// that roscpp's, which allocates whatever a length field asks for, never reads them.
#pragma once

#include "deformable_surface/ros/cloud_decoder.h"

#include <boost/shared_ptr.hpp>
#include <ros/exceptions.h>
#include <ros/message_traits.h>
#include <ros/node_handle.h>
#include <ros/serialization.h>

#include <functional>
#include <string>
#include <vector>

namespace deformable_surface::node {

/// A PointCloud2 in its serialised form. It is not decoded here, because roscpp shares one message among all subscribers of a
/// topic in a process, and these may have different limits.
struct BoundedCloud {
  std::vector<std::uint8_t> bytes;
};

}  // namespace deformable_surface::node

namespace ros {
namespace message_traits {

template <>
struct IsMessage<deformable_surface::node::BoundedCloud> : TrueType {};
template <>
struct IsMessage<const deformable_surface::node::BoundedCloud> : TrueType {};

template <>
struct MD5Sum<deformable_surface::node::BoundedCloud> {
  static const char* value() { return MD5Sum<sensor_msgs::PointCloud2>::value(); }
  static const char* value(const deformable_surface::node::BoundedCloud&) { return value(); }
};

template <>
struct DataType<deformable_surface::node::BoundedCloud> {
  static const char* value() { return DataType<sensor_msgs::PointCloud2>::value(); }
  static const char* value(const deformable_surface::node::BoundedCloud&) { return value(); }
};

template <>
struct Definition<deformable_surface::node::BoundedCloud> {
  static const char* value() { return Definition<sensor_msgs::PointCloud2>::value(); }
  static const char* value(const deformable_surface::node::BoundedCloud&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

/// Reads only.
template <>
struct Serializer<deformable_surface::node::BoundedCloud> {
  template <typename Stream>
  static void read(Stream& stream, deformable_surface::node::BoundedCloud& message) {
    const std::uint32_t size = stream.getLength();
    const std::uint8_t* begin = stream.advance(size);
    message.bytes.assign(begin, begin + size);
  }
  template <typename Stream>
  static void write(Stream&, const deformable_surface::node::BoundedCloud&) {
    throw Exception("BoundedCloud can only be received");
  }
  static std::uint32_t serializedLength(const deformable_surface::node::BoundedCloud&) { return 0; }
};

}  // namespace serialization
}  // namespace ros

namespace deformable_surface::node {

/// Subscribes to a PointCloud2 topic through the decoder. The callback gets refused clouds too, to report them.
inline ros::Subscriber subscribeCloud(ros::NodeHandle& node, const std::string& topic, std::uint32_t queue_size,
                                      const DecodeLimits& limits, const std::function<void(DecodedCloud&&)>& callback) {
  const auto decode = [limits, callback](const boost::shared_ptr<const BoundedCloud>& message) {
    callback(decodeCloud(message->bytes.data(), message->bytes.size(), limits));
  };
  return node.subscribe<BoundedCloud>(topic, queue_size, decode);
}

}  // namespace deformable_surface::node
