// A smoother surface for display: a cubic patch for each triangle, from the positions and normals at its corners [Szeliski and
// Tonnesen 1991, sec. 5].
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/model/deformable_model.h"

#include <vector>

namespace deformable_surface::model {

struct CurvedTriangles {
  Points positions, normals;                // (k x 3) m; unit; the corners first, in their order
  std::vector<WeightedTriangle> triangles;  // the weights of those that they are part of
  std::vector<double> values;               // (k), linear between corners; empty if none are given
};

/// Divides each edge into so many pieces, and so each triangle into pieces^2, and lays the points on the PN triangle of the
/// corners [Vlachos 2001], which is one choice of the paper's patch: edges leave each corner in its tangent plane, the middle is
/// that of the quadratic patch, normals are interpolated quadratically. Points and normals of an edge depend on its two ends
/// alone, so that neighbouring patches share them. Planes stay flat to rounding. The distance from a sphere falls with the fourth
/// power of the edge length, that of flat triangles with the square. pieces 1: the triangles as they are.
///
/// positions, normals (n x 3, unit); pieces >= 1; values: one per position, such as a colour's, or none. Throws InputError if
/// sizes or pieces do not fit. O(triangles pieces^2).
CurvedTriangles curveTriangles(const Points& positions, const Points& normals, const std::vector<WeightedTriangle>& triangles,
                               Index pieces, const std::vector<double>& values = {});

}  // namespace deformable_surface::model
