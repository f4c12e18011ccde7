// Where the surface of a depth image goes on from pixel to pixel. Private.
#pragma once

#include "deformable_surface/cloud/pixel_links.h"
#include "depth_windows.h"

namespace deformable_surface::cloud {

/// Two neighbouring pixels are linked if the planes that they took agree half-way between them: up to what noise leaves of both
/// planes, and up to half the distance of pixels.
PixelLinks linkPixels(const DepthImage& image, const FittedDepths& fitted);

}  // namespace deformable_surface::cloud
