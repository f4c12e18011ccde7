// Links between pixels of a depth image over which the surface continues. Private.
#pragma once

#include "deformable_surface/cloud/pixel_links.h"
#include "depth_windows.h"

#include <cmath>

namespace deformable_surface::cloud {

/// Tolerances on the difference of inverse depth of two planes that agree. sureStep: some standard deviations of the noise left
/// in both. leastStep: half the distance of pixels at that inverse depth.
inline double sureStep(const PixelPlane& a, const PixelPlane& b) {
  constexpr double kSure = 5.0;
  return kSure * std::sqrt(a.deviation * a.deviation + b.deviation * b.deviation);
}
inline double leastStep(const DepthImage& image, double inverse_depth) { return 0.5 * image.pixel() * inverse_depth; }

/// Two neighbouring pixels are linked if their planes agree half-way between them: up to the noise left in both planes, and half
/// the distance of pixels. No link is as steep as the ramps that smoothing makes of steps.
PixelLinks linkPixels(const DepthImage& image, const FittedDepths& fitted);

}  // namespace deformable_surface::cloud
