// Where the surface of a depth image goes on from pixel to pixel. Private.
#pragma once

#include "deformable_surface/cloud/pixel_links.h"
#include "depth_windows.h"

#include <cmath>

namespace deformable_surface::cloud {

/// Differences of inverse depth that two planes may have and still agree: of five standard deviations of what noise leaves of
/// both, and of half the distance of pixels at that inverse depth.
inline double sureStep(const PixelPlane& a, const PixelPlane& b) {
  constexpr double kSure = 5.0;
  return kSure * std::sqrt(a.deviation * a.deviation + b.deviation * b.deviation);
}
inline double leastStep(const DepthImage& image, double inverse_depth) { return 0.5 * image.pixel() * inverse_depth; }

/// Two neighbouring pixels are linked if the planes that they took agree half-way between them: up to what noise leaves of both
/// planes, and up to half the distance of pixels. No link is as steep as the ramps that smoothing makes of steps.
PixelLinks linkPixels(const DepthImage& image, const FittedDepths& fitted);

}  // namespace deformable_surface::cloud
