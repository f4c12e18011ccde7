// The thread in which what is to be seen of the surface is made and published: the stepping thread hands moments over and never
// waits for one to be shown. A file of its own, because all that the two threads share is here: the moments that wait.
#pragma once

#include "moment.h"

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace deformable_surface::node {

class FrameThread {
 public:
  /// show: is called in this thread, with one moment after the other, and must not throw. num_threads: of its loops over points;
  /// >= 1.
  FrameThread(std::function<void(Moment&)> show, int num_threads);
  /// What waits is not shown any more.
  ~FrameThread();
  FrameThread(const FrameThread&) = delete;
  FrameThread& operator=(const FrameThread&) = delete;

  /// One that still waits gives way to it, unless that is to be kept. Waits only while several wait that are.
  void show(Moment&& moment);
  /// How many gave way.
  int numDropped() const;

 private:
  void run();

  const std::function<void(Moment&)> show_;
  mutable std::mutex mutex_;
  std::condition_variable came_, left_;
  std::deque<Moment> waiting_;  // all but the last are to be kept
  bool is_ended_ = false;
  int num_dropped_ = 0;
  std::thread thread_;
};

}  // namespace deformable_surface::node
