// Whether a tracked surface is lost: the last cloud shows few of the points that clouds have shown before. The simulation reports
// it in notices, and the node in its diagnostics.
#pragma once

#include "deformable_surface/base/types.h"

#include <algorithm>
#include <optional>

namespace deformable_surface::simulation {

class TrackingWatch {
 public:
  /// tracked: simulation points that the cloud shows which is tracked from now on.
  void see(Index tracked) {
    last_ = tracked;
    most_ = std::max(most_, tracked);
  }
  /// Until the next cloud nothing is lost, as after a snapshot is restored.
  void forgetLast() { last_.reset(); }

  /// The last cloud shows no point, or less than half of the most that one cloud has shown.
  bool isLost() const { return last_ && (*last_ == 0 || 2 * *last_ < most_); }
  Index last() const { return last_.value_or(0); }
  Index most() const { return most_; }

 private:
  std::optional<Index> last_;  // none: no cloud yet
  Index most_ = 0;
};

}  // namespace deformable_surface::simulation
