// A message type that takes part in ~tools and leaves every message unread: tools are refused while there are none, and what is
// refused anyway must not be given memory by the lengths that it claims.
#pragma once

#include "deformable_surface/ToolArray.h"

#include <ros/message_traits.h>
#include <ros/serialization.h>

namespace deformable_surface::node {

struct UnreadTools {};

}  // namespace deformable_surface::node

namespace ros {
namespace message_traits {

template <>
struct MD5Sum<deformable_surface::node::UnreadTools> {
  static const char* value() { return MD5Sum<deformable_surface::ToolArray>::value(); }
  static const char* value(const deformable_surface::node::UnreadTools&) { return value(); }
};

template <>
struct DataType<deformable_surface::node::UnreadTools> {
  static const char* value() { return DataType<deformable_surface::ToolArray>::value(); }
  static const char* value(const deformable_surface::node::UnreadTools&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<deformable_surface::node::UnreadTools> {
  template <typename Stream>
  static void read(Stream&, deformable_surface::node::UnreadTools&) {}
};

}  // namespace serialization
}  // namespace ros
