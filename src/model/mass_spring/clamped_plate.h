// A plate of which patches are held, as the bending energy has to see it. Curvature jumps where a clamp ends, from that of the
// patch, which cannot bend, to that of what is free; and it ends where somebody said, seldom at a point. So the points of the
// edge are moved there, and ride on those that are held.
#pragma once

#include "deformable_surface/model/mass_spring/curvature_bending.h"

namespace deformable_surface::model {

struct ClampedPlate {
  PlateRest plate;                     // (n + e): the points that there are, then those on edges of clamps
  Index num_points;                    // n
  std::vector<EdgePoint> edge_points;  // (e)
  std::vector<char> is_inner;          // (n) 1: held by a clamp; none of the triangles has it
  Index num_hinged = 0;                // edges that nothing carries, as what is held with them lies in one line

  bool isEdge(Index i) const { return i >= num_points; }
  /// What moves as the patch does.
  bool isClamped(Index i) const { return isEdge(i) || is_inner[i]; }
};

/// held (n) by the number of a patch, see Clamping, or empty if nothing is. edges: of held points beside free ones, where the
/// clamp ends near them, at rest; held points beside free ones that have none are hinges, and so are those that lie in one line
/// with all that are held with them.
ClampedPlate clampPlate(const PlateRest& plate, const std::vector<char>& held, const std::vector<ClampEdge>& edges);

}  // namespace deformable_surface::model
