// What a second copy of a coarser surface needs of the first, but for its pins.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

namespace deformable_surface::simulation {

/// Points, what is known of their shape, and a clone of the model.
inline RestSurface copyPointsAndModel(const RestSurface& of) {
  RestSurface s;
  s.area = of.area;
  s.across = of.across;
  s.closed = of.closed;
  s.points = of.points;
  s.normals = of.normals;
  s.dense_index = of.dense_index;
  s.rings = of.rings;
  s.model = of.model->clone();
  return s;
}

}  // namespace deformable_surface::simulation
