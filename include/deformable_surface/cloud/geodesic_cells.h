// Neighbours of few points of a surface, found over the many it was sampled with: a gap that the full cloud resolves is narrower
// than the spacing of the points that are left, so that these alone cannot show it.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

/// The chosen points, the nearest of them over the surface for every point, and who is beside whom.
struct GeodesicCells {
  Points chosen;             // (m x 3)
  std::vector<Index> owner;  // (n) in 0 .. m - 1; -1 where no path leads to a chosen point
  Lists neighbors;           // (m) chosen points, nearest first by Euclidean distance, at most k
};

/// positions (n x 3) with their neighbours over the surface (keepGeodesicNeighbors); chosen: (m) indices of positions, ascending;
/// k: neighbours wanted. Paths are made of listed pairs and as long as these are in space. Two chosen points are beside each
/// other where their cells touch and the path over them is no detour; neighbours are those that a short way from cell to
/// cell leads to. O(n k log n).
GeodesicCells findGeodesicCells(const Points& positions, const Lists& neighbors, const std::vector<Index>& chosen, Index k);

/// The k chosen points nearest to every point (n) that are its cell's, neighbours of it, or theirs without a detour; points
/// without a cell get the nearest in space. Nearest first. Parallel; O(n (log m + k)).
Lists findChosenNear(const GeodesicCells& cells, const Points& positions, Index k);
/// The same for any points (p x 3) of which owner (p) tells the cell, as cells.owner does.
Lists findChosenNear(const GeodesicCells& cells, const std::vector<Index>& owner, const Points& positions, Index k);

}  // namespace deformable_surface::cloud
