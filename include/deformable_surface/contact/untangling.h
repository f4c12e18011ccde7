// Forces that push crossed parts of a surface apart. Contact cannot: its springs keep each part on the side where it is.
#pragma once

#include "deformable_surface/contact/pair_list.h"

#include <array>
#include <vector>

namespace deformable_surface::contact {

/// A crossing of an edge and a triangle, with the direction in which to push.
struct Push {
  std::array<Index, 5> vertices;  // of the edge and the triangle
  /// Of the relative displacement of the two at the point at which they cross: the edge's sum to 1, the triangle's to -1.
  std::array<double, 5> weight;
  Vec3 direction;  // of the force on the edge, at most of length 1
};

/// Determines how to push the edges and triangles that cross. positions: (n) m; masses: (n) kg. Triangles are oriented alike.
///
/// A closed line of crossings, or one from border to border, cuts a part off the surface [Baraff 2003]. The lighter part is
/// pushed back to where the other one is, across the triangles that it has passed. Lines that cut nothing off are shortened:
/// edges are pushed along the gradient of their length [Volino 2006], here without the change of the triangles beside the edge.
/// Where a line is straight, its gradient vanishes, and only its ends are pushed. Forces and torques of a push are in balance.
/// O(n log n).
std::vector<Push> findPushes(const PairList& pairs, const Points& positions, const std::vector<double>& masses);

}  // namespace deformable_surface::contact
