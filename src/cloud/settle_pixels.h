// Decides on which side of a step in depth a pixel beside it lies, by the surrounding pixels. Private.
#pragma once

#include "depth_windows.h"

namespace deformable_surface::cloud {

/// A pixel beside a step, whose noise reaches the other side, fits a window there. So each pixel takes one of the planes of the
/// surrounding pixels and its own: the one that fits it and with which most of these pixels agree, with the least (misfit /
/// deviation)^2 - 2 x (pixels that agree), in a few rounds. Away from steps nothing changes.
void settlePixels(const DepthImage& image, const NoiseProfile& noise, FittedDepths& fitted);

}  // namespace deformable_surface::cloud
