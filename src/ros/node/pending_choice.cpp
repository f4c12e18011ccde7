#include "pending_choice.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <utility>

namespace deformable_surface::node {
namespace {

// How soon a wait sees that it must end.
constexpr std::chrono::milliseconds kLookPeriod(20);

using Candidate = simulation::AccuracyChoice::Candidate;

// How many times the work of `points` points all of the cloud are expected to take, as the work grew in the choice from the last
// trial to the chosen number; 0: not known.
double expectWorkOfAll(const simulation::AccuracyChoice& choice, Index points, Index num_cloud) {
  if (choice.candidates.empty()) return 0.0;
  const Candidate& last = choice.candidates.back();
  if (!(choice.points > last.points && last.work > 0.0 && choice.work > 0.0)) return 0.0;
  const double exponent = std::log(choice.work / last.work) / std::log(static_cast<double>(choice.points) / last.points);
  return std::pow(static_cast<double>(num_cloud) / points, exponent);
}

}  // namespace

bool isFound(const simulation::AccuracyChoice& choice, double target) {
  const auto is_below = [&](const Candidate& tried) {
    return tried.points == choice.points && !tried.is_bounded && tried.error <= target;
  };
  return choice.is_met || std::any_of(choice.candidates.begin(), choice.candidates.end(), is_below);
}

std::string sayNotFound(const simulation::AccuracyChoice& choice, double target, Index points, Index num_cloud) {
  std::string tried;
  for (const Candidate& candidate : choice.candidates) {
    // One below the target was ended before its error was known.
    const bool is_known = std::isfinite(candidate.error) && candidate.error > target;
    tried += (tried.empty() ? "" : ", ") + std::to_string(candidate.points) +
             (is_known ? ": " + formatShort(candidate.error) + " m" : ": not known");
  }
  std::string sentence = "trials found no number of points that is known to meet accuracy.position_error; the surface has its " +
                         std::to_string(points) + " points, after ~reset, too";
  if (points < num_cloud) {
    sentence += "; without accuracy.position_error, simplification.method: none simulates all";
    const double work = expectWorkOfAll(choice, points, num_cloud);
    if (work > 0.0) sentence += ", which is expected to take " + formatShort(work) + " times the work";
  }
  return sentence + "; errors expected in the trials, by points: " + tried;
}

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

bool PendingChoice::wait(double seconds, const std::function<bool()>& ends) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  std::unique_lock<std::mutex> lock(mutex_);
  while (!made_ && !ends() && std::chrono::duration<double>(Clock::now() - begin).count() < seconds)
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
