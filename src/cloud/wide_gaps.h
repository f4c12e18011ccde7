// Wide angles without neighbours around a point. Boundaries and geodesics both use it. It takes the nearest neighbours first, and
// stops when no wide gap is left.
#pragma once

#include "deformable_surface/geometry/direction.h"

#include <cmath>

namespace deformable_surface::cloud {

/// The gaps between directions in a plane that are wider than an angle (rad, from a third of a turn to half a turn: there are at
/// most two of them).
class WideGaps {
 public:
  explicit WideGaps(double angle) : cosine_(std::cos(angle)) {}

  /// No direction yet: a gap of a full turn.
  void clear() { count_ = -1; }

  /// Divides the gap that q points into. Zero is no direction.
  void add(const Vec2& q) {
    const double squared = q.squaredNorm();
    if (!(squared > 0.0)) return;
    const End end{q, squared, geometry::directionOf(q)};
    if (count_ < 0) {
      count_ = 1;
      gaps_[0] = {end, end, 4.0};
      return;
    }
    for (int g = 0; g < count_; ++g) {
      const Gap gap = gaps_[g];
      double first = end.direction - gap.from.direction;
      if (first < 0.0) first += 4.0;
      if (!(first < gap.width)) continue;
      gaps_[g] = gaps_[--count_];
      const Gap halves[] = {{gap.from, end, first}, {end, gap.to, gap.width - first}};
      for (const Gap& half : halves)
        if (isWide(half)) gaps_[count_++] = half;
      return;
    }
  }

  bool isEmpty() const { return count_ == 0; }

 private:
  struct End {
    Vec2 q;
    double squared, direction;
  };
  // Counter-clockwise; width as the directions count.
  struct Gap {
    End from, to;
    double width;
  };

  bool isWide(const Gap& gap) const {
    return gap.width >= 2.0 || gap.from.q.dot(gap.to.q) < cosine_ * std::sqrt(gap.from.squared * gap.to.squared);
  }

  double cosine_;
  int count_ = -1;  // of gaps; negative before the first direction
  Gap gaps_[3];     // one more than can remain
};

}  // namespace deformable_surface::cloud
