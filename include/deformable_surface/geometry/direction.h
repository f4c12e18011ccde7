// Directions in the plane, compared without trigonometry. Stars and gaps between neighbours both use
// them.
#pragma once

#include "deformable_surface/base/types.h"

#include <cmath>

namespace deformable_surface::geometry {

inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Grows with the angle of v (not zero) from 0 to 4 over a full turn, and by 2 over every half turn. It selects instead of
/// branching: the quadrants of neighbours are unpredictable.
inline double directionOf(const Vec2& v) {
  const double x = std::abs(v.x()), y = std::abs(v.y());
  const bool left = v.x() < 0.0, below = v.y() < 0.0;
  return (below ? (left ? 2.0 : 3.0) : (left ? 1.0 : 0.0)) + (left == below ? y : x) / (x + y);
}

}  // namespace deformable_surface::geometry
