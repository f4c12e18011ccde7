// Which pixels of a depth image are neighbours on the surface, and lists of neighbours made from them. Rows and columns replace
// the searches of kd_tree.h and geodesics.h.
#pragma once

#include "deformable_surface/base/types.h"

#include <cstdint>
#include <vector>

namespace deformable_surface::cloud {

/// Columns and rows from a pixel to its eight neighbours; direction d + 4 is opposite to direction d.
constexpr int kPixelSteps[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};

struct PixelLinks {
  Index width = 0, height = 0;
  std::vector<std::uint8_t> links;  // (height x width) bit d: the surface continues to the pixel in direction d; symmetric

  std::vector<Index> input;  // (height x width) point of the input cloud at each pixel, -1: none; empty: the same index

  bool isEmpty() const { return links.empty(); }
  /// (height x width) The point of each pixel, -1: none. point_of_input: of each point of the input cloud, -1: none.
  std::vector<Index> findPoints(const std::vector<Index>& point_of_input) const;
};

/// For each point, the k nearest in space of the points that can be reached over links, along points that are nearer than the
/// last of them; fewer if fewer can be reached. Nearest first, ties by index. point: (height x width) of each pixel, -1: none.
/// min_gap, m: pixels no farther apart are linked as well, both adjacent ones and those with a few pixels without points in
/// between. Parallel; O(n k).
Lists findNeighbors(const PixelLinks& image, const std::vector<Index>& point, const Points& positions, Index k,
                    double min_gap = 0.0);

}  // namespace deformable_surface::cloud
