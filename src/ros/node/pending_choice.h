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

/// Whether trials found that this choice meets the target (m), or a trial of it stayed below the target without a bound.
/// Otherwise a live surface does not begin with it: it may be far slower, and nothing is known of its error.
bool isFound(const simulation::AccuracyChoice& choice, double target);
/// For a choice that is not found: what was tried, that a surface of this many points has its place, and how to simulate all.
/// num_cloud: of the cloud.
std::string sayNotFound(const simulation::AccuracyChoice& choice, double target, Index points, Index num_cloud);

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

  /// Waits until it is made or ends() is true, but not longer than this (s). Returns whether it is made.
  bool wait(double seconds, const std::function<bool()>& ends);
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
