// Holes in a layer of triangles, filled where the surface is known to go on.
#pragma once

#include "deformable_surface/contact/self_contact.h"

#include <vector>

namespace deformable_surface::simulation {

/// A triangle that fills a hole, and the triangles of the surface on which it lies: at its middle, half-way from there to its
/// corners, and at the middles of its edges. One of the surface's own lies on itself alone.
struct Filling {
  contact::Triangle triangle;
  std::vector<contact::Triangle> beneath;
};

/// Triangles that continue those of a layer, without overlap, where others of the surface lie: first some of these, then new ones
/// between neighbouring edges of a hole. rest: (n) m; layer: neighbours traverse their common edge in opposite directions;
/// surface: triangles that overlap each other and those of the layer. Greedy: narrow holes can stay.
std::vector<Filling> fillHoles(const Points& rest, const std::vector<contact::Triangle>& layer,
                               const std::vector<contact::Triangle>& surface);

}  // namespace deformable_surface::simulation
