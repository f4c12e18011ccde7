#include "pending_choice.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"

#include <exception>
#include <new>
#include <utility>

namespace deformable_surface::node {
namespace {

// How soon a wait sees the flag that ends it.
constexpr std::chrono::milliseconds kLookPeriod(20);

}  // namespace

PendingChoice::PendingChoice(const simulation::SceneParams& params, cloud::PointCloud cloud, int num_threads,
                             std::function<void()> on_made)
    : thread_([this, params, cloud = std::move(cloud), num_threads, on_made = std::move(on_made)]() mutable {
        setNumThreads(num_threads);
        Made made = make(params, std::move(cloud));
        {
          const std::lock_guard<std::mutex> lock(mutex_);
          made_ = std::move(made);
        }
        came_.notify_all();
        on_made();
      }) {}

PendingChoice::~PendingChoice() {
  is_ended_ = true;
  thread_.join();
}

// No content of a cloud may end the thread.
PendingChoice::Made PendingChoice::make(const simulation::SceneParams& params, cloud::PointCloud&& cloud) const {
  const Index num_points = cloud.size();
  const InterruptScope scope(is_ended_);
  Made made;
  try {
    made.simulation = std::make_unique<simulation::Simulation>(params, std::move(cloud));
    made.viewer = std::make_unique<simulation::Simulation>(made.simulation->viewer());
  } catch (const std::bad_alloc&) {
    made.problem = std::to_string(num_points) + " points do not fit in memory; accepted: fewer";
  } catch (const std::exception& error) {
    made.problem = error.what();
  }
  return made;
}

bool PendingChoice::wait(double seconds, const std::atomic<bool>& ends) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  std::unique_lock<std::mutex> lock(mutex_);
  while (!made_ && !ends && std::chrono::duration<double>(Clock::now() - begin).count() < seconds)
    came_.wait_for(lock, kLookPeriod);
  return made_.has_value();
}

bool PendingChoice::isMade() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return made_.has_value();
}

PendingChoice::Made PendingChoice::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return *std::exchange(made_, std::nullopt);
}

}  // namespace deformable_surface::node
