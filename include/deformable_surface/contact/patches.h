// A triangulated surface divided into small compact patches, and the motion of these patches relative to each other.
#pragma once

#include "deformable_surface/contact/box_tree.h"

#include <array>
#include <vector>

namespace deformable_surface::contact {

using Triangle = std::array<Index, 3>;
using Edge = std::array<Index, 2>;  // the lower vertex first

/// Every vertex that is given, edge and triangle belongs to one patch. An edge and a triangle belong to the patch of their lowest
/// vertex.
class Patches {
 public:
  static constexpr Index kMostVertices = 12;  // 6, 12 and 24 cost about the same for a shell that snaps

  /// rest: (n) m. vertices: with all ends of the edges and corners of the triangles. Splits them recursively at the median along
  /// the widest axis. Deterministic.
  Patches(const Points& rest, const std::vector<Index>& vertices, const std::vector<Edge>& edges,
          const std::vector<Triangle>& triangles);

  Index size() const { return static_cast<Index>(patches_.size()) - 1; }

  // Of a patch, ascending.
  template <class Visit>
  void visitVertices(Index patch, const Visit& visit) const {
    for (Index k = patches_[patch].vertices; k < patches_[patch].outside; ++k) visit(corners_[k]);
  }
  template <class Visit>
  void visitEdges(Index patch, const Visit& visit) const {
    for (Index k = patches_[patch].edges; k < patches_[patch + 1].edges; ++k) visit(edges_[k]);
  }
  template <class Visit>
  void visitTriangles(Index patch, const Visit& visit) const {
    for (Index k = patches_[patch].triangles; k < patches_[patch + 1].triangles; ++k) visit(triangles_[k]);
  }

  /// Of all that belongs to a patch, m.
  Box boundOf(Index patch, const Points& positions) const;

  /// Bounds of the displacements of all points in a patch.
  struct Ways {
    Vec3 least, largest;  // m

    /// Upper bound of the difference of the displacements of a point of each patch, m.
    double findRelative(const Ways& other) const { return (largest - other.least).cwiseMax(other.largest - least).norm(); }
  };
  /// ways: (patches), of the displacements between two positions.
  void measureWays(const Points& from, const Points& to, std::vector<Ways>& ways) const;
  /// The same for some of the patches; the ways of the others stay.
  void measureWays(const Points& from, const Points& to, const std::vector<Index>& patches, std::vector<Ways>& ways) const;
  /// For ways in any direction, from their greatest lengths: lengths: (n) m.
  void boundWays(const std::vector<double>& lengths, std::vector<Ways>& ways) const;

 private:
  Ways waysOf(Index patch, const Points& from, const Points& to) const;

  // Where the parts of a patch begin in the arrays below. They end where those of the next patch begin.
  struct Patch {
    Index vertices, outside;  // outside: the corners of its edges and triangles that belong to other patches
    Index edges, triangles;
  };
  std::vector<Patch> patches_;  // and one behind the last
  std::vector<Index> corners_, edges_, triangles_;
};

/// Upper bound of the difference of the displacements of any two points, m.
double findLargestRelativeWay(const Points& from, const Points& to);

}  // namespace deformable_surface::contact
