// The volume of a body that each of its points represents, and its share of the boundary. Pure geometry,
// without a material.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::model {

/// Volume and boundary area of each point. For a planar body, area and length take their place.
struct PointCells {
  std::vector<double> volume;  // (n) m^3, or m^2
  Points outside;  // (n x 3) outward area vector of its part of the body's outside, m^2, or m; zero inside, also where a cell
                   // just reaches the surface
};

/// How points outline a body. kSurface: points lie on its surface everywhere. kRough: points lie near it at best, with dents
/// between them, like the remaining points of a simplified cloud.
enum class Outline { kSurface, kRough };

/// Voronoi cells among neighbours, cut by the convex hull of a point and its neighbours: a point on a flat face has half a cell,
/// on a straight edge a quarter. On a convex body they sum to the volume of the hull of its points. Where the hull spans a
/// gap, in a hole or beside a concave edge, a point loses the directions in which empty spheres that touch it and its neighbours
/// are wider than the spacing allows: the body ends at the facets between its points. Not for rough outlines, whose dents look
/// like gaps.
/// points (n x 3) m; neighbors: of every point, as far as its cell may reach (about thirty, in a plane sixteen); across: unit
/// normal of the plane of a planar body, or zero. Parallel; O(n k^2).
PointCells findPointCells(const Points& points, const Lists& neighbors, const Vec3& across, Outline outline = Outline::kSurface);

/// (m) m^3, or m^2: volume of the points (n x 3) nearest to each of m others. owner (n): that one. Of clouds above 20,000
/// points some 20,000 cells are measured, and gaps between their neighbours are not cut off.
std::vector<double> measureAround(const Points& points, const Lists& neighbors, const Vec3& across,
                                  const std::vector<Index>& owner, Index m);

/// Multiplies the volume of each point (n), which has its whole cell, by the share that is material: of the volume around
/// each point, on average over its neighbours, and all alike so that the sum is that of the volumes around them. Cells reach
/// across the walls of a body whose points are too few for them.
void fillCells(const std::vector<double>& around, const Lists& neighbors, std::vector<double>& volume);

/// Of the spacing: no place in a body is farther from all of its points. With jitter of four tenths some are 1.27 away in a
/// plane.
constexpr double kEmptySphere = 1.4;

/// (n) m, the local spacing: that of as many cells in a lattice. Cells of slender bodies are all cut by the hull; the spacing is
/// then at least the distance to the nearest points. volume: (n) of the cells, m^3, or m^2.
std::vector<double> findPointSpacing(const Points& points, const Lists& neighbors, const std::vector<double>& volume,
                                     bool is_planar);

}  // namespace deformable_surface::model
