// Rows and columns of a depth image whose points came as a list: drivers and filters that drop missing pixels drop the grid with
// them. Private: see depth_image.h.
#pragma once

#include "deformable_surface/cloud/clean.h"

#include <optional>

namespace deformable_surface::cloud {

struct PixelGrid {
  Index width = 0, height = 0;
  std::vector<Index> input;  // (height x width) point of the cloud at each pixel, -1: none
};

/// The grid of a pinhole camera at input.eye() that looks along the z axis: there x / z takes one value per column, and y / z one
/// per row, evenly spaced. None if the points show no such values, two points share a pixel, or most pixels are missing. cloud:
/// clean(input). O(n log n).
std::optional<PixelGrid> findPixelGrid(const PointCloud& input, const CleanCloud& cloud);

}  // namespace deformable_surface::cloud
