// Whether something happens in many steps: told once, unlike what lasts (lasting_notices.h), which comes and goes.
#pragma once

#include "deformable_surface/base/types.h"

namespace deformable_surface::simulation {

/// Counts in periods of a second of simulated time, or of ten steps if these take longer.
class FrequentSteps {
 public:
  /// Ends a step at a time, s, of this length. Returns true once, until clear(): it has happened in more than a tenth of the
  /// steps of the period that ends.
  bool endStep(double end, double step, bool happens);
  void clear() { *this = FrequentSteps(); }

  // Of the period that ended last.
  Index count() const { return last_count_; }  // steps in which it happened
  Index steps() const { return last_steps_; }

 private:
  bool is_told_ = false;
  Index happened_ = 0, all_ = 0;
  Index last_count_ = 0, last_steps_ = 0;
  double begin_ = 0.0;  // s
};

}  // namespace deformable_surface::simulation
