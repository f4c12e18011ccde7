// Limits the motion of points in a step, whatever the forces are: for surfaces that must not pass through each other.
#pragma once

#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface::solve {

class MotionLimit {
 public:
  virtual ~MotionLimit() = default;

  /// Shortens the straight motion of each point from `before` to `after` (n x 3, m), also of held points that are carried. Any
  /// part of the shortened motion is admissible, too. continues: `before` is where the last call ended. Returns the stopped
  /// points, ascending; valid until the next call.
  virtual const std::vector<Index>& limit(const Points& before, Points& after, bool continues) const = 0;
  /// (n) of each point: the number, below n, of the connected part to which it belongs. Parts without stopped points bear nothing
  /// of what stopping does to energy. Empty where no point is ever stopped.
  virtual const std::vector<Index>& parts() const = 0;
};

}  // namespace deformable_surface::solve
