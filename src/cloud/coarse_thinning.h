// The first part of the simplification of a large cloud: by distances alone, in parallel and in linear time. It ends at a number
// of points whose rings simplify() can treat one by one in about a second.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

/// A cloud that is being thinned: the remaining points, in the order of the input.
struct ThinnedCloud {
  std::vector<Index> index;  // (n) of the points left, ascending
  Points positions;          // (n x 3)
  Lists neighbors;           // (n) indices into index, nearest first, of the same part
  std::vector<Index> part;   // (n)
  std::vector<char> stays;   // (n) never removed
  // The removed points, in order, and the ring diameter of each removal, m: running maximum.
  std::vector<Index> removed;
  std::vector<double> diameter;
};

/// Removes points until at most `stop`, or a few times as many, are left. Round by round the least distance becomes as
/// large as the lists allow, in the last round level by level. In the order of the input, a point stays unless a nearer one
/// stays; else it goes at twice their distance, the ring diameter of a hexagonal lattice of that spacing. After a round, the
/// wanted number of neighbours is found again among the remaining points; over_surface: those that short paths over the
/// former ones lead to. Parts of which few would be left stay as they are. Never leaves fewer than stop. neighbors: of the whole
/// cloud, nearest first, of other parts too; cloud.neighbors is empty at first. O(n log n).
void thinCoarsely(const Lists& neighbors, Index stop, Index wanted, bool over_surface, ThinnedCloud& cloud);

}  // namespace deformable_surface::cloud
