// The connected parts of a triangulated surface and the loops of their boundaries, as clearance.h needs them.
#pragma once

#include "deformable_surface/base/types.h"

#include <array>
#include <vector>

namespace deformable_surface::contact {

struct Outlines {
  struct Loop {
    Index first;   // in loop_points
    Index middle;  // a point without triangles inside the hole; -1: none
    bool is_hole;
  };
  struct Part {
    Index first_point, first_triangle, first_loop;  // the ranges end where those of the next part begin
  };
  std::vector<Part> parts;                      // and one more; none: see findOutlines()
  std::vector<Index> points;                    // by part
  std::vector<std::array<Index, 3>> triangles;  // by part
  std::vector<Loop> loops;                      // by part, and one more
  std::vector<Index> loop_points;               // with the surface on the left
  double edge = 0.0;                            // m, the median edge of the surface

  Index numParts() const { return parts.empty() ? 0 : static_cast<Index>(parts.size()) - 1; }
};

/// rest: (n) m. Each part has one loop around it; the others surround holes. Small holes are filled up with triangles that the
/// surface does not have, and so are places where a loop runs towards its middle or back. Finds nothing if two triangles pass an
/// edge in the same direction, if a part has no boundary, if a point without triangles lies in no hole of its own, or if there
/// are many parts. O(n log n), and a time of the square of the points of each loop that is filled up.
Outlines findOutlines(const Points& rest, const std::vector<std::array<Index, 3>>& triangles);

}  // namespace deformable_surface::contact
