#include "deformable_surface/contact/crossings.h"

#include "deformable_surface/base/error.h"

#include <string>

namespace deformable_surface::contact {

std::vector<Edge> listEdges(Index n, const std::vector<Triangle>& triangles) {
  std::vector<Edge> edges;
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      if (t[k] < 0 || t[k] >= n)
        throw InputError("contact: found a triangle with vertex " + std::to_string(t[k]) + "; accepted: 0 to " +
                         std::to_string(n - 1));
      edges.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace deformable_surface::contact
