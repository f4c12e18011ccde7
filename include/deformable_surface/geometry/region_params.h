// How scenes describe a region. Loops over points need only the region itself (region.h).
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/geometry/region.h"

#include <string>

namespace deformable_surface::geometry {

inline void visitRegion(Fields& fields, Region& region) {
  // Bounds of a box may lie far outside any cloud, to mean a half-space.
  const bool is_box = fields.begin("box", region.kind == Region::Kind::kBox, "");
  if (is_box) {
    fields.required().vector("min", region.min, "m", anyFinite(), "corner with the smallest coordinates");
    fields.required().vector("max", region.max, "m", anyFinite(), "corner with the largest coordinates");
    for (int axis = 0; axis < 3; ++axis)
      fields.require(region.min[axis] <= region.max[axis], "min",
                     "found " + formatReal(region.min[axis]) + " in " + "xyz"[axis] + ", which is above max, " +
                         formatReal(region.max[axis]) + "; accepted: min <= max in x, y and z");
    fields.end();
  }
  const bool is_sphere = fields.begin("sphere", region.kind == Region::Kind::kSphere, "");
  if (is_sphere) {
    region.kind = Region::Kind::kSphere;
    fields.required().vector("center", region.center, "m", anyFinite(), "centre");
    fields.required().number("radius", region.radius, "m", between(0.0, 2.0 * kMaxLength), "radius");
    fields.end();
  }
  fields.require(is_box != is_sphere, "",
                 std::string("found ") + (is_box ? "both" : "neither") + " of box and sphere; accepted: one");
  fields.flag("outside", region.outside, "select the points outside the shape");
}

}  // namespace deformable_surface::geometry
