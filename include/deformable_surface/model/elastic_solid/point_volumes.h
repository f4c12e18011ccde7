// How much of a body each of its points stands for, and how much of its outside. It is a file of its own because it is geometry
// alone, without a material.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::model {

/// What each point stands for. Of a planar body area and length take the place of volume and area.
struct PointCells {
  std::vector<double> volume;  // (n) m^3, or m^2
  Points outside;  // (n x 3) outward area vector of its part of the body's outside, m^2, or m; zero inside, also where a cell
                   // just reaches the surface
};

/// How points outline a body: some of them lie on its surface wherever that is; or at most near it, with dents between them, as
/// those do that are left of a cloud.
enum class Outline { kSurface, kRough };

/// Voronoi cells among neighbours, cut by the convex hull of a point and them: a point on a flat face has half a cell, on a
/// straight edge a quarter, and on a convex body they sum to the volume of the hull of its points. Where the hull reaches over a
/// gap, in a hole or beside a concave edge, a point loses the directions in which empty spheres that touch it and its neighbours
/// are wider than the spacing allows: the body ends at the facets between its points. Not of rough outlines, whose dents look as
/// gaps do.
/// points (n x 3) m; neighbors: of every point, as far as its cell may reach (some thirty, in a plane sixteen); across: unit
/// normal of the plane of a planar body, or zero. Parallel; O(n k^2).
PointCells findPointCells(const Points& points, const Lists& neighbors, const Vec3& across, Outline outline = Outline::kSurface);

}  // namespace deformable_surface::model
