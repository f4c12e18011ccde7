// Where a held patch ends: its region says so, and seldom at a point. What a model makes of it: model::Clamping().
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include <functional>

namespace deformable_surface::simulation {

/// A surface as it is and as it was at rest.
struct ClampedSurface {
  const Points& rest;
  const Points& now;
  const Lists& ring;
  const std::vector<char>& open;  // 1: on a free edge
  const std::vector<model::WeightedTriangle>& triangles;
};

using Contains = std::function<bool(const Vec3&)>;

struct ClampEdges {
  std::vector<Index> riding;            // ascending: points outside that ride with the patch, as they are too near to its edge
  std::vector<model::ClampEdge> edges;  // ascending
};

/// clamping (n): points inside the region that belong to a patch that clamps. contains: whether a place of the surface as it is
/// lies in the region. Edges are where it ends between points, to a thousandth of their distance.
ClampEdges findClampEdges(const ClampedSurface& surface, const std::vector<char>& clamping, const Contains& contains);

/// Which of the points inside, (n), belong to a patch that clamps: one wider than a row of points. spacing: of the points, m.
std::vector<char> markClamping(const Points& points, const Lists& neighbors, const std::vector<char>& inside, double spacing);

/// Whether pins can clamp: without a curvature energy nothing tells a clamp from a hinge.
bool canClamp(const SceneParams& params);

/// Finds where the scene's pins clamp, and marks what rides on them. full: the surface with the dense points that s is of.
void clampPins(const SceneParams& params, const RestSurface& full, RestSurface& s);

}  // namespace deformable_surface::simulation
