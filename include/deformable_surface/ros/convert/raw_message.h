// A message type that receives another type but keeps its bytes, for a decoder of our own. roscpp's decoder, which allocates
// whatever a length field asks for, never reads them. Clouds and tools are received this way.
#pragma once

#include <ros/exceptions.h>
#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <cstdint>
#include <vector>

namespace deformable_surface::node {

/// A Message in its serialised form. It is not decoded here: roscpp shares one message among all subscribers of a topic
/// in a process, and these may have different limits.
template <class Message>
struct RawMessage {
  std::vector<std::uint8_t> bytes;
};

}  // namespace deformable_surface::node

namespace ros {
namespace message_traits {

template <class Message>
struct IsMessage<deformable_surface::node::RawMessage<Message>> : TrueType {};
template <class Message>
struct IsMessage<const deformable_surface::node::RawMessage<Message>> : TrueType {};

template <class Message>
struct MD5Sum<deformable_surface::node::RawMessage<Message>> {
  static const char* value() { return MD5Sum<Message>::value(); }
  static const char* value(const deformable_surface::node::RawMessage<Message>&) { return value(); }
};

template <class Message>
struct DataType<deformable_surface::node::RawMessage<Message>> {
  static const char* value() { return DataType<Message>::value(); }
  static const char* value(const deformable_surface::node::RawMessage<Message>&) { return value(); }
};

template <class Message>
struct Definition<deformable_surface::node::RawMessage<Message>> {
  static const char* value() { return Definition<Message>::value(); }
  static const char* value(const deformable_surface::node::RawMessage<Message>&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

/// Reads only.
template <class Message>
struct Serializer<deformable_surface::node::RawMessage<Message>> {
  template <typename Stream>
  static void read(Stream& stream, deformable_surface::node::RawMessage<Message>& message) {
    const std::uint32_t size = stream.getLength();
    const std::uint8_t* begin = stream.advance(size);
    message.bytes.assign(begin, begin + size);
  }
  template <typename Stream>
  static void write(Stream&, const deformable_surface::node::RawMessage<Message>&) {
    throw Exception("RawMessage can only be received");
  }
  static std::uint32_t serializedLength(const deformable_surface::node::RawMessage<Message>&) { return 0; }
};

}  // namespace serialization
}  // namespace ros
