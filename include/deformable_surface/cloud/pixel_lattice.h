// The lattice of every second pixel of every second row of a depth image, and the lattice pixels that each other pixel follows.
// It is fine enough for simulation points that are many pixels apart, at a quarter of the time.
#pragma once

#include "deformable_surface/cloud/pixel_links.h"

namespace deformable_surface::cloud {

struct PixelLattice {
  PixelLinks links;           // of the lattice: present where two links of the image lead from one pixel to the next
  std::vector<Index> points;  // (m) points of the lattice, ascending
  std::vector<Index> place;   // (lattice height x width) index into points of each lattice pixel; -1: no point
  /// (n) for each point of the image the lattice points that it follows, as indices into points, nearest first: itself; otherwise
  /// those at one link, or the nearest at two or three links; none if no links lead to any.
  Lists followed;
};

/// point: (height x width) of each pixel, -1: none; of pixels that share a point, only the first counts. Parallel; O(n).
PixelLattice takeEverySecond(const PixelLinks& image, const std::vector<Index>& point, const Points& positions);

}  // namespace deformable_surface::cloud
