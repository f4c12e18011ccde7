// The Delaunay triangles at one point among its projected neighbours, without triangulating the rest: the neighbours are inverted
// about the point. The edges of their convex hull that avoid the point give its triangles.
#pragma once

#include "deformable_surface/base/types.h"

#include <cstdint>

namespace deformable_surface::geometry {

/// Angle (rad) by which opposite angles of a quadrilateral may miss the straight angle for its corners to count as cocircular:
/// far above the rounding of float coordinates and the curvature of a well-sampled surface, far below any effect on springs.
constexpr double kStarTie = 0.02;

/// Widest angle (rad) that a triangle may have at the origin: the straight angle less an allowance for rounding.
constexpr double kStarMaxGap = 3.14159;

/// The star of the origin among neighbours in the plane. Neighbours that are cocircular with the origin and a hull edge are all
/// kept: they form one Delaunay cell (on a square grid: the square), and every triangulation of it is equally good.
struct DelaunayStar {
  std::vector<Index> ring;       // positions in the neighbour list, counter-clockwise; starts after the widest gap if open
  std::vector<Index> cell_size;  // (ring size) for the step ring[r] -> next: corners of its Delaunay cell, the origin included;
                                 // 0 = no triangle, so the last step of an open ring has 0
  bool open = false;             // some step has no triangle: the ring does not close

  double area = 0.0;   // m^2, of all triangles (origin, ring[r], next)
  double share = 0.0;  // m^2, this point's part: each cell's area divided by its number of corners
};

/// Whether a further point leaves a closed star as it is: it lies outside the circle of the triangle in whose direction it is, by
/// more than the tie (rad) of build(). points: those of build().
bool isOutside(const Vec2& point, const std::vector<Vec2>& points, const DelaunayStar& star, double tie = kStarTie);

/// Reusable scratch memory of the computation.
class DelaunayStarBuilder {
 public:
  /// points (n) are the neighbours relative to the origin, any order. Neighbours at the origin are ignored. Of several in one
  /// direction only the nearest can be in the ring. tie: angle (rad, below 1) within which a neighbour counts as cocircular; the
  /// test gives the same result from every corner of a cell of four: their stars agree. max_gap: angle (rad, up to
  /// kStarMaxGap) beyond which two consecutive ring members span no triangle, nor an end of an open ring with the next member.
  /// No usable neighbours: an empty ring; one, or all on one line: a ring without triangles.
  /// Cost O(n log n). [Su 2007, sec. 3; the inversion is a standard duality of Delaunay triangulation and convex hull]
  const DelaunayStar& build(const std::vector<Vec2>& points, double tie = kStarTie, double max_gap = kStarMaxGap);

 private:
  struct Direction {
    double angle;  // grows with the angle, in [0, 4)
    double squared_distance;
    Index neighbor;
  };

  void sortByDirection(const std::vector<Vec2>& points);
  void findHull(const std::vector<Vec2>& points);
  void fillRing(const std::vector<Vec2>& points, double tie, double max_gap_cosine);
  void openRing(const std::vector<Vec2>& points, double max_gap_cosine);
  void trimRing(const std::vector<Vec2>& points, double max_gap_cosine);
  void measureCells(const std::vector<Vec2>& points, double tie);

  DelaunayStar star_;
  std::vector<Direction> unsorted_;
  std::vector<double> angle_;          // of unsorted_
  std::vector<std::int64_t> place_;    // of unsorted_ in the sorted ones; as wide as an angle, so that vectors of both match
  std::vector<Direction> directions_;  // counter-clockwise; from findHull on they start at a corner of the hull
  std::vector<Vec2> image_;            // of directions_
  std::vector<Index> hull_;            // positions in directions_, ascending
};

}  // namespace deformable_surface::geometry
