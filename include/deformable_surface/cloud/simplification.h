// Fewer points that still sample the surface evenly [Su 2007, sec. 3]: the point with the smallest ring goes first. The order of
// removal is recorded, so that every threshold and every wanted number of points is a prefix of one pass.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

struct Simplification {
  Index num_points = 0;           // of the input
  std::vector<Index> removed;     // in the order of removal
  std::vector<double> diameter;   // m: running maximum of the key at removal; never falls
  Index num_left_out = 0;         // parts too small for the target, all of whose points go first
  Index num_left_out_points = 0;  // of these parts

  /// The points left when target points remain (all removable ones gone if it is smaller), ascending.
  std::vector<Index> keepCount(Index target) const;
  /// The points left when the rings of all removable ones have reached the threshold (m), ascending.
  std::vector<Index> keepDiameter(double threshold) const;
};

/// k: neighbours of the star (10 .. 20; at least 3). min_points: the pass stops there. protected_points are never removed; nor
/// are corners (Boundary::is_corner), found on the input cloud once; and every part of the surface (connected by links that
/// LinkRule accepts) keeps at least three of its points, or all if it has fewer. Stars see the points of their own part only.
/// The key is (ring diameter + 2 nearest distance) / 2: equal to the diameter on a hexagonal lattice, it spaces points more
/// evenly than the diameter of [Su 2007]. Ties are broken by index. O(n k log n).
Simplification simplify(const Points& positions, const Points& normals, Index k, Index min_points,
                        const std::vector<Index>& protected_points);

/// The same for those who have found the neighbours (2k of every point, nearest first) and the corners already.
/// over_surface: the neighbours are those over the surface (keepGeodesicNeighbors), and stars never look across a gap that they
/// tell, however far apart the points left are. target: how many points will be asked for (0: min_points): of a large cloud rings
/// decide from a few times as many on. The order depends on it, and on min_points in nothing but where it ends. Parts whose share
/// of the target is less than three points are left out if they would keep more than a tenth of it.
/// wanted: (n) the spacing wanted around each point, over the mean, above 0, little different from neighbour to neighbour. Keys,
/// and so diameters, are divided by it, so that all prefixes are graded alike. Empty: even spacing.
Simplification simplify(const Points& positions, const Points& normals, Index k, Index min_points,
                        const std::vector<Index>& protected_points, const Lists& neighbors, const std::vector<char>& is_corner,
                        bool over_surface, Index target = 0, const std::vector<double>& wanted = {});

}  // namespace deformable_surface::cloud
