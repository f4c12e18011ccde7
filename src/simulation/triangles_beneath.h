// On which triangles of a surface the places of another triangle lie. Private.
#pragma once

#include "deformable_surface/contact/box_tree.h"
#include "deformable_surface/contact/self_contact.h"

#include <array>
#include <vector>

namespace deformable_surface::simulation {

/// Finds triangles beneath places. Keeps references to its arguments.
class TrianglesBeneath {
 public:
  /// rest: (n) m.
  TrianglesBeneath(const Points& rest, const std::vector<contact::Triangle>& triangles);

  /// The nearest triangle at a place (m) of t that faces as t does; false if there is none.
  bool find(const contact::Triangle& t, const Vec3& place, contact::Triangle& beneath) const;

 private:
  const Points& rest_;
  const std::vector<contact::Triangle>& triangles_;
  contact::BoxTree tree_;
};

/// The middle of a triangle and the places half-way from there to its corners, m.
std::array<Vec3, 4> listPlaces(const Points& rest, const contact::Triangle& t);

}  // namespace deformable_surface::simulation
