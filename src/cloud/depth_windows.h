// Finds the surface of a noisy depth image: every pixel takes the plane of a window that noise alone explains. Private.
#pragma once

#include "depth_image.h"
#include "noise_profile.h"

namespace deformable_surface::cloud {

/// Measures the noise of the image, in inverse depth.
NoiseProfile measureNoise(const DepthImage& image);

/// Inverse depth around a pixel as a plane, and the standard deviation of its value there. Level without a window.
struct PixelPlane {
  double along_u = 0.0, along_v = 0.0, deviation = 0.0;
};

/// Inverse depths on the surface. Windows have (2 radius + 1)^2 pixels and are fitted by an affine function of the pixel. Noise
/// explains a window if its residuals are no larger than the noise. A pixel takes, of the explained windows that contain it, the
/// one with the nearest centre that it fits. Beside a step in depth that is one on its own side. A pixel that fits none of them
/// takes the nearest. Real noise is correlated: larger windows have more of it. So the variance of the noise is taken as the
/// median of the windows of that radius, at least the given one and at most three times that.
struct FittedDepths {
  std::vector<double> inverse_depth;  // (height x width); unchanged for pixels without explained windows
  std::vector<PixelPlane> planes;     // (height x width) through these values
  Index unexplained = 0;              // pixels that fit no window
  double factor = 1.0;                // of the noise in windows of this radius, over the given noise
};
FittedDepths fitWindows(const DepthImage& image, const NoiseProfile& noise, Index radius);

}  // namespace deformable_surface::cloud
