// The first part of the simplification of a large cloud: by distances alone, in parallel and in linear time, down to as many
// points as the rings of simplify() can be asked one by one for in about a second.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

/// A cloud that is being thinned: what is left of it, in the order of the input.
struct ThinnedCloud {
  std::vector<Index> index;  // (n) of the points left, ascending
  Points positions;          // (n x 3)
  Lists neighbors;           // (n) indices into index, nearest first, of the same part
  std::vector<Index> part;   // (n)
  std::vector<char> stays;   // (n) never removed
  // What was removed, in order, and at which ring diameter, m: running maximum.
  std::vector<Index> removed;
  std::vector<double> diameter;
};

/// Removes points until at most as many as stop, or a few times that, are left. Round by round the least distance becomes as
/// large as the lists allow, in the last round level by level: in the order of the input a point stays unless one that stays is
/// nearer, and then goes at twice their distance, the ring diameter of a hexagonal lattice of that spacing. After a round the
/// neighbours (as many as wanted) are found anew among the points that are left; over_surface: those that short ways over the
/// ones before lead to. Parts of which few would be left stay as they are. Never leaves fewer than stop. neighbors: of the whole
/// cloud, nearest first, of other parts too; cloud.neighbors is empty at first. O(n log n).
void thinCoarsely(const Lists& neighbors, Index stop, Index wanted, bool over_surface, ThinnedCloud& cloud);

}  // namespace deformable_surface::cloud
