// Where the surface lies that a noisy depth image shows: every pixel takes the plane of a window that noise alone explains.
// Private.
#pragma once

#include "depth_image.h"
#include "noise_profile.h"

namespace deformable_surface::cloud {

/// What noise the image has, in inverse depth.
NoiseProfile measureNoise(const DepthImage& image);

/// How the inverse depth goes on from a pixel, and the standard deviation of what it is there. Level without a window.
struct PixelPlane {
  double along_u = 0.0, along_v = 0.0, deviation = 0.0;
};

/// Inverse depths on the surface. A window of (2 radius + 1)^2 pixels, an affine function of the pixel, is explained by noise if
/// what it leaves is no more than that; a pixel takes, of those that contain it, the one in whose middle it is and that it
/// fits. Beside a step in depth that is one on its own side. A pixel that fits none of them goes to the nearest.
/// Real noise is correlated: the larger the window, the more of it there is. So it counts with what half of the windows of that
/// radius leave, at least with what is given and at most with three times its square.
struct FittedDepths {
  std::vector<double> inverse_depth;  // (height x width); of a pixel without explained windows what it was
  std::vector<PixelPlane> planes;     // (height x width) through that
  Index unexplained = 0;              // pixels that fit no window
  double factor = 1.0;                // of the noise in windows of this radius, over that given
};
FittedDepths fitWindows(const DepthImage& image, const NoiseProfile& noise, Index radius);

}  // namespace deformable_surface::cloud
