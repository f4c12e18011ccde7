// Clouds that wait: for the transform of their frame, or for the step that begins at their stamp. In a file of its own because a
// transform that always comes a little later than the next cloud must not keep every cloud from being taken.
#pragma once

#include "inbox.h"

#include <chrono>
#include <deque>
#include <functional>

namespace deformable_surface::node {

class WaitingClouds {
 public:
  using SteadyTime = Inbox::SteadyTime;
  enum class Answer { kTake, kWait, kRefuse };

  /// Too many: the oldest is dropped.
  void put(IncomingCloud&& cloud);
  bool isEmpty() const { return clouds_.empty(); }
  void clear() { clouds_.clear(); }
  std::size_t size() const { return clouds_.size(); }

  /// Asks of each cloud, the newest first, what is to become of it, and returns the first that is to be taken; those that came
  /// before it are dropped. is_patient: its transform is still waited for. Refused ones are dropped.
  std::optional<IncomingCloud> take(const std::function<Answer(IncomingCloud& cloud, bool is_patient)>& ask);

  /// How many gave way to newer ones.
  int numDropped() const { return num_dropped_; }

 private:
  struct Entry {
    IncomingCloud cloud;
    SteadyTime give_up;
  };
  std::deque<Entry> clouds_;  // the oldest first
  int num_dropped_ = 0;
};

}  // namespace deformable_surface::node
