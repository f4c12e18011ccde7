// The thread that makes and publishes what is displayed of the surface. The stepping thread hands moments over. It waits
// for one to be shown only where several wait that must be kept. The two threads share only the waiting moments.
#pragma once

#include "moment.h"

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace deformable_surface::node {

class FrameThread {
 public:
  /// show: called in this thread, with one moment after the other; must not throw. num_threads: of its loops over points;
  /// >= 1.
  FrameThread(std::function<void(Moment&)> show, int num_threads);
  /// Waiting moments are not shown any more.
  ~FrameThread();
  FrameThread(const FrameThread&) = delete;
  FrameThread& operator=(const FrameThread&) = delete;

  /// Replaces a waiting moment, unless that one must be kept. One that must be kept itself blocks while several such moments
  /// wait.
  void show(Moment&& moment);
  /// Waits until the last result of a call that was handed over before is shown. For any thread but the one that shows.
  void waitForResult();
  /// How many were replaced.
  int numDropped() const;

 private:
  void run();

  const std::function<void(Moment&)> show_;
  mutable std::mutex mutex_;
  std::condition_variable came_, left_, shown_;
  std::deque<Moment> waiting_;  // all but the last are to be kept
  bool is_ended_ = false;
  std::uint64_t num_results_ = 0, num_results_shown_ = 0;
  int num_dropped_ = 0;
  std::thread thread_;
};

}  // namespace deformable_surface::node
