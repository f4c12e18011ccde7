// A thread for a queue of callbacks. Unlike roscpp's AsyncSpinner it does not wake up ten times a second to check
// whether to end: a node whose surface rests uses no time.
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
  /// Waits for the running callback; no others are called.
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
