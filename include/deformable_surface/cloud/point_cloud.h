// The point set of input and output: positions, further fields of the points, and the shape of the message or file.
#pragma once

#include "deformable_surface/base/types.h"

#include <cstddef>
#include <optional>
#include <string>

namespace deformable_surface::cloud {

/// Scalar types of a field; the values are those of sensor_msgs/PointField.
enum class ScalarType : std::uint8_t {
  kInt8 = 1,
  kUint8 = 2,
  kInt16 = 3,
  kUint16 = 4,
  kInt32 = 5,
  kUint32 = 6,
  kFloat32 = 7,
  kFloat64 = 8
};

/// Bytes of one scalar.
constexpr std::size_t sizeOf(ScalarType type) {
  constexpr std::size_t kSizes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

/// A field of the input beyond position and normal (colour, intensity, ...), passed on unchanged.
struct ExtraField {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::uint32_t count = 1;          // scalars per point
  std::vector<std::uint8_t> bytes;  // (n x count) scalars in the host's byte order
};

/// A surface as a point set. Points that are not finite are holes: they keep their place, so that the output has one point per
/// input point in the same order.
struct PointCloud {
  Points positions;  // (n x 3) m
  Points normals;    // (n x 3) unit, outward; empty if the input brings none
  std::vector<ExtraField> extra_fields;
  std::uint32_t width = 0, height = 1;  // width * height == n; height > 1 for organised clouds
  std::optional<Vec3> viewpoint;        // where the scanner stood, if the file says so
  Vec3 origin = Vec3::Zero();           // m, of the frame that the cloud came in; a depth camera sees from there

  Index size() const { return static_cast<Index>(positions.size()); }
  /// Where the points were seen from, if a camera or scanner saw them; m.
  Vec3 eye() const { return viewpoint.value_or(origin); }
};

}  // namespace deformable_surface::cloud
