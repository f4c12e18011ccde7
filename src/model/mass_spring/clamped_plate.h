// A plate with held patches, for the bending energy. At the edge of a clamp, curvature jumps from that of the patch, which cannot
// bend, to that of the free part. The edge is given by the user, and seldom lies on points. So the points of the edge are moved
// onto it, and follow held points.
#pragma once

#include "deformable_surface/model/mass_spring/curvature_bending.h"

namespace deformable_surface::model {

struct ClampedPlate {
  PlateRest plate;                     // (n + e): the actual points, then those on edges of clamps
  Index num_points;                    // n
  std::vector<EdgePoint> edge_points;  // (e)
  std::vector<char> is_inner;          // (n) 1: held by a clamp; no triangle uses it
  Index num_hinged = 0;                // edges without support, since the points held there are collinear

  bool isEdge(Index i) const { return i >= num_points; }
  /// Whether the point moves with its patch.
  bool isClamped(Index i) const { return isEdge(i) || is_inner[i]; }
};

/// held (n): the number of each point's patch, see Clamping, or empty if no points are held. edges: for held points beside free
/// ones, the nearby end of the clamp, at rest. Held points beside free ones without an edge are hinges, and so are those that are
/// collinear with all points held with them.
ClampedPlate clampPlate(const PlateRest& plate, const std::vector<char>& held, const std::vector<ClampEdge>& edges);

}  // namespace deformable_surface::model
