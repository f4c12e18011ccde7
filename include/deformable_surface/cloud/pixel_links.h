// Which pixels of a depth image are neighbours on the surface, and from that lists of neighbours. Beside kd_tree.h and
// geodesics.h, because rows and columns tell at once what those must search for.
#pragma once

#include "deformable_surface/base/types.h"

#include <cstdint>
#include <vector>

namespace deformable_surface::cloud {

/// Columns and rows from a pixel to its eight neighbours; the opposite of the d-th is the d + 4th.
constexpr int kPixelSteps[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};

struct PixelLinks {
  Index width = 0, height = 0;
  std::vector<std::uint8_t> links;  // (height x width) bit d: the surface goes on to the pixel in direction d; symmetric

  bool isEmpty() const { return links.empty(); }
};

/// The k nearest in space of those points that links lead to from each point, over points that are nearer than the last of them;
/// fewer where they lead to fewer. Nearest first, ties by index. point: (height x width) of each pixel, -1: none. min_gap, m:
/// pixels that are no farther apart are linked, too, neighbouring ones and those with a few pixels without points in between.
/// Parallel; O(n k).
Lists findNeighbors(const PixelLinks& image, const std::vector<Index>& point, const Points& positions, Index k,
                    double min_gap = 0.0);

}  // namespace deformable_surface::cloud
