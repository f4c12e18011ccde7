#include "deformable_surface/ros/convert/tool_decoder.h"

#include <ros/serialization.h>

namespace deformable_surface::node {
namespace {

using ros::serialization::IStream;

// Bytes of one element on the wire.
constexpr std::uint64_t kReal = 8, kTriangle = 3 * 4, kPoint = 3 * 8;
// More than the longest primitive needs, with room for later ones.
constexpr std::uint32_t kMaxDimensions = 16;

/// Skips an array whose length comes next, without reading it: advance() throws beyond the end.
std::uint32_t skipArray(IStream& stream, std::uint64_t element) {
  std::uint32_t count;
  stream.next(count);
  if (count * element > stream.getLength()) ros::serialization::throwStreamOverrun();
  stream.advance(static_cast<std::uint32_t>(count * element));
  return count;
}

/// Reads an array whose length comes next, after checking that the bytes suffice.
template <class Element>
void readArray(IStream& stream, std::uint64_t element, std::vector<Element>& array) {
  IStream ahead = stream;
  skipArray(ahead, element);
  stream.next(array);
}

// In the order of Tool.msg.
Tool readTool(IStream& stream) {
  Tool tool;
  stream.next(tool.header);
  stream.next(tool.id);
  stream.next(tool.action);
  stream.next(tool.mode);
  stream.next(tool.shape);
  stream.next(tool.primitive.type);
  IStream dimensions = stream;
  if (skipArray(stream, kReal) <= kMaxDimensions)
    dimensions.next(tool.primitive.dimensions);
  else
    tool.primitive.dimensions.resize(kMaxDimensions);  // a wrong number in any case, which the conversion refuses
  stream.next(tool.plane);
  readArray(stream, kTriangle, tool.mesh.triangles);
  readArray(stream, kPoint, tool.mesh.vertices);
  stream.next(tool.pose);
  stream.next(tool.twist);
  stream.next(tool.follow_frame);
  stream.next(tool.friction);
  stream.next(tool.kinetic_friction);
  stream.next(tool.strength);
  return tool;
}

}  // namespace

DecodedTools decodeTools(const std::uint8_t* bytes, std::size_t size) {
  DecodedTools decoded;
  // The stream only reads, whatever its type says.
  IStream stream(const_cast<std::uint8_t*>(bytes), static_cast<std::uint32_t>(size));
  try {
    std::uint32_t count;
    stream.next(count);
    if (count > kMaxTools) {
      decoded.problem = "found " + std::to_string(count) + " tools in a message; accepted: up to " + std::to_string(kMaxTools);
      return decoded;
    }
    for (std::uint32_t i = 0; i < count; ++i) decoded.tools.push_back(readTool(stream));
    if (stream.getLength() == 0) return decoded;
    decoded.problem = "found " + std::to_string(stream.getLength()) + " bytes behind the last tool; accepted: none";
  } catch (const ros::serialization::StreamOverrunException&) {
    decoded.problem =
        "found a message of " + std::to_string(size) + " bytes, which is shorter than it claims; accepted: whole ones";
  }
  decoded.tools.clear();
  return decoded;
}

}  // namespace deformable_surface::node
