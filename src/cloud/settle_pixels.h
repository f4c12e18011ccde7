// Which side of a step in depth a pixel beside it lies on, by the pixels around it. Private.
#pragma once

#include "depth_windows.h"

namespace deformable_surface::cloud {

/// A pixel beside a step whose noise reaches as far as the other side fits a window there. So of the planes that the pixels
/// around it took, and its own, each takes the one that fits it and that most of these pixels agree with: of least
/// (misfit / deviation)^2 - 2 x (pixels that agree), in a few rounds. Away from steps nothing changes.
void settlePixels(const DepthImage& image, const NoiseProfile& noise, FittedDepths& fitted);

}  // namespace deformable_surface::cloud
