// What breaks where it is stretched too far. The march asks for it within a step, so that what tears does not depend on the
// length of steps.
#pragma once

#include "deformable_surface/model/deformable_model.h"

#include <optional>

namespace deformable_surface::solve {

class Breaking {
 public:
  virtual ~Breaking() = default;

  /// Whether any element of the surface's model, or of a part that it has made (Partition), is stretched too far. O(elements),
  /// parallel.
  virtual bool isAnyStretched(const model::DeformableModel& model, const model::State& state) const = 0;
  /// A solver has reached this state, and continues from it: all elements that are stretched too far break, and the surface's
  /// model has no forces of them any longer. Returns the elastic energy, J, that went with them; none: nothing broke.
  virtual std::optional<double> breakStretched(const model::State& state) = 0;
  /// What broke since the step began is whole again.
  virtual void takeBack() = 0;
};

}  // namespace deformable_surface::solve
