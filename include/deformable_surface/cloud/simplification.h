// Reduces the points of a surface evenly [Su 2007, sec. 3]: the point with the smallest ring goes first. The order of
// removal is recorded, so that every threshold and every wanted number of points is a prefix of one pass.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

struct Simplification {
  Index num_points = 0;          // of the input
  std::vector<Index> removed;    // in the order of removal
  std::vector<double> diameter;  // m: running maximum of the key at removal; never falls
  Index num_left_out = 0;        // parts too small for the target; all of their points go first
  std::vector<Index> left_out;   // the points of these parts, ascending

  /// The points left when `target` points remain (or no removable ones, if target is smaller), ascending.
  std::vector<Index> keepCount(Index target) const;
  /// The points left when the rings of all removable ones have reached the threshold (m), ascending.
  std::vector<Index> keepDiameter(double threshold) const;
};

/// k: neighbours of the star (10 .. 20; at least 3). min_points: the pass stops there. protected_points are never removed.
/// Corners (Boundary::is_corner, found on the input cloud once) are never removed either. Every part of the surface (connected by
/// links that LinkRule accepts) keeps at least three points, or all if it has fewer. Stars see points of their own part only.
/// The key is (ring diameter + 2 nearest distance) / 2: equal to the diameter on a hexagonal lattice, it spaces points more
/// evenly than the diameter of [Su 2007]. Ties are broken by index. O(n k log n).
Simplification simplify(const Points& positions, const Points& normals, Index k, Index min_points,
                        const std::vector<Index>& protected_points);

/// So many points are thinned one by one in less than a second.
constexpr Index kOneByOne = 25000;

/// The same for callers that have the neighbours (2k of every point, nearest first) and the corners already.
/// over_surface: the neighbours are those along the surface (keepGeodesicNeighbors). Stars then never look across a gap that
/// these show, however far apart the remaining points are. target: the number of points wanted (0: min_points): in a large cloud
/// rings decide only from a few times as many on. The order depends on target; min_points only decides where it ends. Parts whose
/// share of the target is less than three points are left out if they would keep more than a tenth of it.
/// wanted: (n) the wanted spacing around each point, over the mean, above 0, varying slowly between neighbours. Keys,
/// and therefore diameters, are divided by it, so that all prefixes are graded alike. Empty: even spacing.
/// one_by_one: of clouds that are some times as large the surplus is removed by distances alone, as long as some times the wanted
/// points are left.
Simplification simplify(const Points& positions, const Points& normals, Index k, Index min_points,
                        const std::vector<Index>& protected_points, const Lists& neighbors, const std::vector<char>& is_corner,
                        bool over_surface, Index target = 0, const std::vector<double>& wanted = {},
                        Index one_by_one = kOneByOne);

}  // namespace deformable_surface::cloud
