// Registers the process again after the roscore was restarted. roscpp does not: the node would vanish from the graph, and nobody
// new could find it, while old connections live on.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace deformable_surface::node {

class RegistrationWatchdog {
 public:
  /// services: resolved names; topics are found by themselves. Runs in a thread of its own, since a master that hangs blocks
  /// whoever asks it.
  explicit RegistrationWatchdog(std::vector<std::string> services);
  ~RegistrationWatchdog();
  RegistrationWatchdog(const RegistrationWatchdog&) = delete;
  RegistrationWatchdog& operator=(const RegistrationWatchdog&) = delete;

 private:
  void run();
  /// True if the process ends meanwhile.
  bool waitOrEnd(std::chrono::milliseconds time);

  const std::vector<std::string> services_;
  const std::string uri_, service_uri_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool is_ended_ = false;
  std::thread thread_;
};

}  // namespace deformable_surface::node
