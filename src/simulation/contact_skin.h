// The triangles of contact: one layer of triangles over the surface, of those of the model and of some that fill holes.
#pragma once

#include "deformable_surface/contact/self_contact.h"
#include "deformable_surface/model/deformable_model.h"

#include <vector>

namespace deformable_surface::simulation {

/// What touches itself, chosen at rest before any cut. Triangles of the model that overlap others are left out: Delaunay cells of
/// more than three corners hold several triangulations, and neighbours on scattered points do not always agree. Holes that this
/// leaves are filled where triangles of the model lie in them.
struct ContactSkin {
  /// rest: (n) m; given: of the whole surface.
  ContactSkin(const Points& rest, const std::vector<model::WeightedTriangle>& given);

  /// Per triangle, whether it is part of a surface that now has the triangles given. One that fills a hole is while all are on
  /// which it lies.
  std::vector<char> findWhole(const std::vector<model::WeightedTriangle>& now) const;

  std::vector<contact::Triangle> triangles;  // those of the model, then those that fill holes
  double share_without;  // of the area of the model's triangles on which none of these lies, 0 to 1. Large between layers nearer
                         // than two spacings or so, and on very uneven clouds

 private:
  std::vector<std::vector<contact::Triangle>> beneath_;  // of each triangle that fills a hole
};

/// One triangulation where several overlap because a Delaunay cell has more than three corners: neighbours on a surface traverse
/// their common edge in opposite directions.
std::vector<contact::Triangle> chooseTriangulation(const std::vector<model::WeightedTriangle>& triangles);

}  // namespace deformable_surface::simulation
