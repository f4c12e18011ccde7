// Every second pixel of every second row of a depth image, and which of these each other pixel goes with. They show as much of
// the surface as simulation points that are many pixels apart can tell, in a quarter of the time.
#pragma once

#include "deformable_surface/cloud/pixel_links.h"

namespace deformable_surface::cloud {

struct PixelLattice {
  PixelLinks links;           // of these pixels: where two links of the image lead from one to the next
  std::vector<Index> points;  // (m) theirs, ascending
  std::vector<Index> place;   // (lattice height x width) of each of these pixels' point among these, -1: it has none
  /// (n) for each point of the image those of the lattice that it goes with, as places among points, nearest first: itself; else
  /// those that a link leads to, or the nearest that two or three lead to; none: links lead to none.
  Lists followed;
};

/// point: (height x width) of each pixel, -1: none; of pixels that share a point only the first counts. Parallel; O(n).
PixelLattice takeEverySecond(const PixelLinks& image, const std::vector<Index>& point, const Points& positions);

}  // namespace deformable_surface::cloud
