// The rings of all points: the Delaunay star of each on its tangent plane, made symmetric, with triangles and area shares. They
// are the surface's connectivity, from which springs, triangles, masses and area vectors come.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

/// Angle (rad) without neighbours beyond which a point may be on the boundary: halfway between the right angle that the diagonal
/// neighbours of a grid leave and the straight angle of an edge.
constexpr double kBoundaryGap = 2.3;

struct Triangle {
  Index corner[3];  // counter-clockwise seen from the tip of the normal; corner[0] is the smallest index
  double weight;    // share of its area it stands for: sum of 1 / (corners of the Delaunay cell) over the stars that hold it
};

struct Rings {
  Lists ring;                       // (n) neighbours counter-clockwise about the normal; symmetric: j in ring(i) <=> i in ring(j)
  std::vector<char> open;           // (n) 1 = the ring does not close (boundary); an open ring starts after its gap
  std::vector<Triangle> triangles;  // each once, sorted by corners
  std::vector<double> area;         // (n) m^2, a third of each weighted triangle's; they sum to the surface's area
  Index num_isolated = 0;           // points without any ring
};

/// Builds the rings from k nearest neighbours. Neighbours that LinkRule refuses (far longer than the local spacing at either end,
/// or steep against either tangent plane) are no links: far outliers and separate parts stay separate. At boundary points a gap
/// wider than kBoundaryGap between ring members spans no triangle. neighbors: nearest first.
/// Parallel; O(n k log k). [Su 2007, sec. 3 and 4.1]
Rings buildRings(const Points& positions, const Points& normals, const Lists& neighbors);

/// The area of the surface, m^2, without making rings. Holes below 5 spacings in radius count in part. neighbors: as above.
/// are_nearest: (n) true for lists that are known to hold the nearest points in space, or empty. It saves time alone.
double measureArea(const Points& positions, const Points& normals, const Lists& neighbors,
                   const std::vector<char>& are_nearest = {});

/// The boundary points of a surface: an angular gap wider than kBoundaryGap among the projected k and again 2k nearest
/// neighbours, and at least two neighbours with such a gap. is_corner marks those where the boundary turns by more than 45
/// degrees. neighbors, nearest first, holds at least 2k per point where the cloud has them.
struct Boundary {
  std::vector<char> is_boundary, is_corner;  // (n)
  std::vector<float> corner_gap;             // (n) rad, of a corner the angle without neighbours; 0: no corner
};
/// Keeps only the `most` sharpest corners; of equal ones the first.
void limitCorners(Index most, Boundary& boundary);
Boundary findBoundary(const Points& positions, const Points& normals, const Lists& neighbors, Index k);

/// The kind of surface: pieces, holes, handles of the triangulation that consists of every point's ring. Where triangles
/// overlap (both diagonals of a tied cell, stars that disagree) the heavier, then the first counts. Gaps that this
/// leaves among points with closed rings count as filled.
struct Topology {
  Index components = 0;            // connected by ring links, isolated points not counted
  Index boundary_loops = 0;        // closed chains of boundary edges
  Index euler_characteristic = 0;  // V - E + F over the triangles followed; exact where the stars agree
};
Topology measureTopology(const Rings& rings);

/// Connected components by ring links: (n) numbered from 0 in the order of the smallest index; isolated points have -1.
std::vector<Index> labelComponents(const Rings& rings, Index& num_components);

}  // namespace deformable_surface::cloud
