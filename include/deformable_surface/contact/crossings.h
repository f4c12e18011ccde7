// Where a surface passes through itself: at an edge that goes through a triangle.
#pragma once

#include "deformable_surface/contact/box_tree.h"
#include "deformable_surface/contact/closest_points.h"
#include "deformable_surface/contact/patches.h"

#include <algorithm>
#include <vector>

namespace deformable_surface::contact {

/// An edge that passes through the inside of a triangle.
struct Crossing {
  Index edge, triangle;
};

template <std::size_t N>
Box boundOf(const Points& positions, const std::array<Index, N>& vertices) {
  Box box;
  for (const Index v : vertices) box.extend(positions[v]);
  return box;
}

/// The edges of triangles, ascending. Throws InputError for vertices other than 0 to n - 1.
std::vector<Edge> listEdges(Index n, const std::vector<Triangle>& triangles);

/// Calls visit(crossing) for every edge that passes through a triangle with which it shares no vertex, in the order of the edges.
/// tree: of the triangles' boxes at these positions, m.
template <class Visit>
void visitCrossings(const Points& positions, const std::vector<Edge>& edges, const std::vector<Triangle>& triangles,
                    const BoxTree& tree, const Visit& visit) {
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto& [a, b] = edges[e];
    tree.visitMeeting(boundOf(positions, edges[e]), [&](Index t) {
      const Triangle& v = triangles[t];
      if (std::find(v.begin(), v.end(), a) != v.end() || std::find(v.begin(), v.end(), b) != v.end()) return;
      if (pierces(positions[a], positions[b], positions[v[0]], positions[v[1]], positions[v[2]]))
        visit(Crossing{static_cast<Index>(e), t});
    });
  }
}

}  // namespace deformable_surface::contact
