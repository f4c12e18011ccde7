// The edges of held patches. They are given by regions, and seldom lie on points. Effect in a model: model::Clamping().
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include <functional>

namespace deformable_surface::simulation {

/// A surface in its present and its rest shape.
struct ClampedSurface {
  const Points& rest;
  const Points& now;
  const Lists& ring;
  const std::vector<char>& open;  // 1: on a free edge
  const std::vector<model::WeightedTriangle>& triangles;
};

using Contains = std::function<bool(const Vec3&)>;

struct ClampEdges {
  std::vector<Index> riding;            // ascending: points outside that move with the patch, as they are too near to its edge
  std::vector<model::ClampEdge> edges;  // ascending
};

/// clamping (n): points inside the region that belong to a clamping patch. contains: whether a place of the present surface lies
/// in the region. Edges are found between points to a thousandth of their distance.
ClampEdges findClampEdges(const ClampedSurface& surface, const std::vector<char>& clamping, const Contains& contains);

/// Which of the points inside, (n), belong to a clamping patch: one wider than a row of points, which may follow the rim of a
/// surface round corners. neighbors: of the points inside and of their neighbours. spacing: of the points, m.
std::vector<char> markClamping(const Points& points, const Lists& neighbors, const std::vector<char>& inside, double spacing);

/// Adds to clamping (n) those points inside, (n), around which the region is wide enough to hold two rows of points of this
/// spacing (m), whatever the distance of the simulation points.
void markWide(const ClampedSurface& surface, const std::vector<char>& inside, const Contains& contains, double spacing,
              std::vector<char>& clamping);

/// Whether pins can clamp: without a curvature energy, a clamp equals a hinge.
bool canClamp(const SceneParams& params);

/// Finds the edges of the clamping pins of a scene, and marks the points that move with them. full: the surface with the dense
/// points of s.
void clampPins(const SceneParams& params, const RestSurface& full, RestSurface& s);

}  // namespace deformable_surface::simulation
