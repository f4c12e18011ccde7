// A convex polyhedron that is cut by half-spaces one after the other: Voronoi cells, and by duality the facets of convex hulls.
// Both use the same code.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::geometry {

class ConvexCell {
 public:
  /// Becomes the cube of all |x|, |y|, |z| <= half_size, m.
  void reset(double half_size);

  /// Removes the half-space normal . x > offset. A plane that cuts no deeper than rounding cuts nothing, so that ties (a
  /// lattice) do not make slivers. If everything is removed, no corner is left. O(corners).
  /// The label, >= 0, identifies the new facet.
  void cut(const Vec3& normal, double offset, int label = 0);

  /// m^3; the origin need not lie inside.
  double volume() const;
  /// Outward area vector of the facets with a label, m^2; those of the cube have -1.
  Vec3 area(int label) const;

  /// Its corners, each once per facet.
  const Points& corners() const { return corners_; }
  /// Calls visit(label, first, last) for every facet: the range of its corners, counter-clockwise from outside.
  template <class Visit>
  void visitFacets(const Visit& visit) const {
    for (std::size_t f = 0; f < labels_.size(); ++f)
      visit(labels_[f], corners_.data() + first_[f], corners_.data() + first_[f + 1]);
  }

 private:
  void endFacet(int label);

  // Facets are loops of corners, counter-clockwise from outside: that of facet f is corners_[first_[f]] .. corners_[first_[f +
  // 1] - 1].
  Points corners_;
  std::vector<Index> first_{0};
  std::vector<int> labels_;  // of the facets
  double half_size_ = 0.0;
  // Scratch.
  Points kept_, rim_;
  std::vector<Index> kept_first_;
  std::vector<int> kept_labels_;
  std::vector<double> height_;
  std::vector<std::pair<double, Index>> order_;
};

}  // namespace deformable_surface::geometry
