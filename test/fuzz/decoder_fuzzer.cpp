// libFuzzer on the decoder of point clouds: any bytes give a cloud within its limits, or a sentence.
#include "deformable_surface/ros/convert/cloud_decoder.h"

#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace deformable_surface;
  const node::DecodeLimits limits{10000, 1e6};
  const node::DecodedCloud decoded = node::decodeCloud(bytes, size, limits);
  if (!decoded.ok()) return 0;
  if (static_cast<Index>(decoded.cloud.positions.size()) > limits.max_points) std::abort();
  for (const Vec3& p : decoded.cloud.positions)
    if (p.allFinite() && !(p.array().abs() <= limits.max_coordinate).all()) std::abort();
  return 0;
}
