#include "link_pixels.h"

#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::cloud {
namespace {

constexpr Index kRowsPerTask = 8;
// Largest change of depth from pixel to pixel over their distance: a surface seen at seven degrees. Cameras that smooth their
// depths make steeper ramps of steps between two surfaces.
constexpr double kSteepest = 8.0;

// q: a pixel du columns and dv rows from p, to the right or below.
bool agree(const DepthImage& image, const FittedDepths& fitted, std::size_t p, std::size_t q, Index du, Index dv) {
  const PixelPlane &a = fitted.planes[p], &b = fitted.planes[q];
  const double w = fitted.inverse_depth[p];
  const double difference = fitted.inverse_depth[q] - w - 0.5 * ((a.along_u + b.along_u) * du + (a.along_v + b.along_v) * dv);
  if (std::abs(fitted.inverse_depth[q] - w) > kSteepest * image.pixel() * w * std::hypot(du, dv)) return false;
  return std::abs(difference) <= std::max(sureStep(a, b), leastStep(image, w));
}

}  // namespace

PixelLinks linkPixels(const DepthImage& image, const FittedDepths& fitted) {
  const Index width = image.width, height = image.height;
  PixelLinks result{width, height, std::vector<std::uint8_t>(image.inverse_depth.size()), {}};
  parallelFor(height, kRowsPerTask, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      for (Index u = 0; u < width; ++u) {
        const std::size_t p = std::size_t(v) * width + u;
        if (!(fitted.inverse_depth[p] > 0.0)) continue;
        for (int d = 0; d < 8; ++d) {
          const Index du = kPixelSteps[d][0], dv = kPixelSteps[d][1];
          if (u + du < 0 || u + du >= width || v + dv < 0 || v + dv >= height) continue;
          const std::size_t q = std::size_t(v + dv) * width + u + du;
          if (!(fitted.inverse_depth[q] > 0.0)) continue;
          // Evaluated identically for both ends.
          const bool are_linked = q > p ? agree(image, fitted, p, q, du, dv) : agree(image, fitted, q, p, -du, -dv);
          if (are_linked) result.links[p] |= 1 << d;
        }
      }
    }
  });
  return result;
}

}  // namespace deformable_surface::cloud
