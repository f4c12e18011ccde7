// The outside of a body that is given by points within it and on it.
#pragma once

#include "deformable_surface/model/capabilities.h"

#include <vector>

namespace deformable_surface::model {

/// The facets between Delaunay cells that are part of a body and those that are not, counter-clockwise seen from outside: an
/// alpha shape [Edelsbrunner and Muecke 1994] of cells among the neighbours of each point. Dents between points on a flat face
/// are outside. The weight is the share of its corners at which a facet was found; on lattices several triangulations overlap.
/// points (n x 3) m; neighbors: of every point, nearest first; about thirty. empty: (n) m, the radius from which on an empty
/// sphere through a point is outside of the body. Parallel; O(n k^2).
std::vector<WeightedTriangle> findBodySkin(const Points& points, const Lists& neighbors, const std::vector<double>& empty);

}  // namespace deformable_surface::model
