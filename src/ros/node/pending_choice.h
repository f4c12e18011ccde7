// A surface in the making whose number of points is chosen by trials for an accuracy target. A thread of its own makes it, so
// that another surface may run meanwhile.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/simulation/simulation.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace deformable_surface::node {

class PendingChoice {
 public:
  struct Made {
    std::unique_ptr<simulation::Simulation> simulation, viewer;
    std::string problem;  // one sentence; empty: they are there
  };

  /// num_threads: of the loops, >= 1. on_made: called in that thread once it is made.
  PendingChoice(const simulation::SceneParams& params, cloud::PointCloud cloud, int num_threads, std::function<void()> on_made);
  /// Ends the trials.
  ~PendingChoice();
  PendingChoice(const PendingChoice&) = delete;
  PendingChoice& operator=(const PendingChoice&) = delete;

  /// Waits until it is made or the flag is true, but not longer than this (s). Returns whether it is made.
  bool wait(double seconds, const std::atomic<bool>& ends);
  bool isMade() const;
  /// Only if it is made, and once.
  Made take();

 private:
  Made make(const simulation::SceneParams& params, cloud::PointCloud&& cloud) const;

  std::atomic<bool> is_ended_{false};
  mutable std::mutex mutex_;
  std::condition_variable came_;
  std::optional<Made> made_;
  std::thread thread_;
};

}  // namespace deformable_surface::node
