// Neighbours of few chosen points of a surface, found over the many points of the full cloud. A gap that the full cloud resolves
// is narrower than the spacing of the chosen points: they alone cannot show it.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

/// The chosen points, the nearest of them along the surface for every point, and the neighbours of each.
struct GeodesicCells {
  Points chosen;             // (m x 3)
  std::vector<Index> owner;  // (n) in 0 .. m - 1; -1 where no path leads to a chosen point
  Lists neighbors;           // (m) chosen points, nearest first by Euclidean distance, at most k
};

/// positions (n x 3) with neighbours along the surface (keepGeodesicNeighbors); chosen: (m) indices of positions, ascending;
/// k: neighbours wanted. Paths consist of listed pairs, with their lengths in space. Two chosen points are adjacent
/// if their cells touch and the path between them is no detour. Neighbours are the chosen points that short paths from cell to
/// cell lead to. O(n k log n).
GeodesicCells findGeodesicCells(const Points& positions, const Lists& neighbors, const std::vector<Index>& chosen, Index k);

/// The k nearest chosen points of every point (n), among its cell's, that one's neighbours, and theirs without a detour. Points
/// without a cell get the nearest in space. Nearest first. Parallel; O(n (log m + k)).
Lists findChosenNear(const GeodesicCells& cells, const Points& positions, Index k);
/// The same for any points (p x 3); owner (p): their cells, as in cells.owner.
Lists findChosenNear(const GeodesicCells& cells, const std::vector<Index>& owner, const Points& positions, Index k);

}  // namespace deformable_surface::cloud
