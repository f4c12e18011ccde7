// A thread that works off a queue of callbacks. In place of roscpp's AsyncSpinner, which wakes up ten times a second to see
// whether it is to end: a node whose surface rests should rest, too.
#pragma once

#include <ros/callback_queue.h>
#include <ros/init.h>

#include <atomic>
#include <thread>

namespace deformable_surface::node {

class QueueThread {
 public:
  explicit QueueThread(ros::CallbackQueue& queue) : queue_(queue) {}
  ~QueueThread() { stop(); }
  QueueThread(const QueueThread&) = delete;
  QueueThread& operator=(const QueueThread&) = delete;

  void start() {
    thread_ = std::thread([this] {
      while (!is_ended_ && ros::ok()) queue_.callAvailable(ros::WallDuration(kPatience));
    });
  }
  /// Waits for the callback that is under way; the queue takes no others.
  void stop() {
    is_ended_ = true;
    queue_.disable();  // which wakes the thread
    if (thread_.joinable()) thread_.join();
  }

 private:
  static constexpr double kPatience = 5.0;  // s: how late the end of roscpp alone is noticed

  ros::CallbackQueue& queue_;
  std::atomic<bool> is_ended_{false};
  std::thread thread_;
};

}  // namespace deformable_surface::node
