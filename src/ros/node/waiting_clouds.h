// Clouds that wait for the transform of their frame, or for the step that begins at their stamp. Even if each
// transform comes a little later than the next cloud, a cloud is taken.
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

  /// If there are too many, the oldest is dropped.
  void put(IncomingCloud&& cloud);
  bool isEmpty() const { return clouds_.empty(); }
  void clear() { clouds_.clear(); }
  std::size_t size() const { return clouds_.size(); }

  /// Asks for each cloud, the newest first, what to do with it, and returns the first one to take. Earlier ones
  /// are dropped. is_patient: it may still wait for its transform. Refused ones are dropped.
  std::optional<IncomingCloud> take(const std::function<Answer(IncomingCloud& cloud, bool is_patient)>& ask);

  /// How many were replaced by newer ones.
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
