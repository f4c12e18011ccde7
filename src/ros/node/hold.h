// Whether the surface is held, and by which call: a copy of it is being worked on that will replace it. A reset ends a hold, and
// another call may hold the surface before the first one is done.
#pragma once

#include <cstdint>

namespace deformable_surface::node {

class Hold {
 public:
  using Id = std::uint64_t;

  Id begin() { return current_ = ++last_; }
  bool isActive() const { return current_ != kNone; }
  /// Ends that hold. Returns whether it was still active; if not, nothing changes.
  bool end(Id id) {
    if (id != current_) return false;
    cancel();
    return true;
  }
  /// Ends any.
  void cancel() { current_ = kNone; }

 private:
  static constexpr Id kNone = 0;

  Id current_ = kNone, last_ = kNone;
};

}  // namespace deformable_surface::node
