// The shapes that select points: closed boxes and balls, or what lies outside of one.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::geometry {

struct Region {
  enum class Kind { kBox, kSphere };
  Kind kind = Kind::kBox;
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  // kBox: corners, m
  Vec3 center = Vec3::Zero();                   // kSphere: m
  double radius = 0.0;                          // kSphere: m
  bool outside = false;                         // all but the points of the closed shape

  bool contains(const Vec3& point) const { return isInShape(point) != outside; }

 private:
  /// True inside and on the surface.
  bool isInShape(const Vec3& point) const {
    if (kind == Kind::kSphere) return (point - center).squaredNorm() <= radius * radius;
    return (point.array() >= min.array()).all() && (point.array() <= max.array()).all();
  }
};

}  // namespace deformable_surface::geometry
