#include "cloud_worker.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/io/cloud_filters.h"
#include "deformable_surface/ros/convert/frames.h"

#include <exception>
#include <new>
#include <optional>
#include <utility>

namespace deformable_surface::node {

CloudWorker::CloudWorker(Inbox& inbox, WarningLog& warnings, const DecodeLimits& limits)
    : inbox_(inbox), warnings_(warnings), limits_(limits), thread_([this] { run(); }) {}

CloudWorker::~CloudWorker() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_ended_ = true;
  }
  came_.notify_all();
  thread_.join();
}

void CloudWorker::put(const boost::shared_ptr<const BoundedCloud>& message) {
  const std::int64_t arrival = inbox_.now();
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counts_.received;
  counts_.ignored += is_ignoring_;
  if (is_ignoring_) return;
  counts_.replaced += arrived_.has_value();
  arrived_ = Arrived{message, arrival};
  came_.notify_one();
}

void CloudWorker::ignore(bool is_ignoring) {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_ignoring_ = is_ignoring;
}

CloudWorker::Counts CloudWorker::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counts_;
}

bool CloudWorker::isBusy() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return is_busy_;
}

bool CloudWorker::hasArrived() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return arrived_.has_value();
}

void CloudWorker::begin(CloudWork&& work) {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_busy_ = true;
  work_ = std::move(work);
  came_.notify_one();
}

std::optional<CloudResult> CloudWorker::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!result_) return std::nullopt;
  // Clouds that came meanwhile are decoded from now on.
  is_busy_ = false;
  came_.notify_one();
  return std::exchange(result_, std::nullopt);
}

void CloudWorker::run() {
  for (;;) {
    std::optional<CloudWork> work;
    std::optional<Arrived> arrived;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      came_.wait(lock, [this] { return is_ended_ || work_ || (arrived_ && !is_busy_); });
      if (is_ended_) return;
      work = std::exchange(work_, std::nullopt);
      if (!work) arrived = std::exchange(arrived_, std::nullopt);
    }
    if (arrived) {
      decode(*arrived);
      continue;
    }
    CloudResult result = carryOut(*work);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      result_ = std::move(result);
    }
    inbox_.wake();
  }
}

void CloudWorker::decode(const Arrived& arrived) {
  DecodedCloud decoded;
  try {
    decoded = decodeCloud(arrived.message->bytes.data(), arrived.message->bytes.size(), limits_);
  } catch (const std::bad_alloc&) {
    decoded.problem =
        std::to_string(arrived.message->bytes.size()) + " bytes do not fit in memory a second time; accepted: fewer";
  }
  if (decoded.ok()) return inbox_.put(std::move(decoded), arrived.arrival);
  warnings_.report(Warning::kCloudRefused, "cloud refused: " + decoded.problem);
  inbox_.wake();
}

// No content of a cloud may end the thread.
CloudResult CloudWorker::carryOut(CloudWork& work) const {
  const Index num_points = work.cloud.size();
  CloudResult result;
  result.stamp = work.stamp;
  result.arrival = work.arrival;
  result.frame = std::move(work.frame);
  result.cloud_frame = std::move(work.cloud_frame);
  const InterruptScope scope(*inbox_.closing());
  try {
    setNumThreads(work.num_threads);
    transformCloud(work.transform, work.cloud);
    const simulation::InputFilterParams& filter = work.params.input.filter;
    if (filter.isOn() && work.kind == CloudWork::Kind::kBuild)
      result.unfiltered = std::make_unique<cloud::PointCloud>(work.cloud);
    io::FilterReport filtered = io::filterCloud(filter, work.cloud);
    if (!filtered.problem.empty()) throw InputError(filtered.problem);
    if (work.kind == CloudWork::Kind::kObserve) {
      result.observed = std::make_shared<const simulation::ObservedCloud>(work.cloud);
    } else {
      build(work, result);
      result.filter_notices = std::move(filtered.notices);
    }
  } catch (const std::bad_alloc&) {
    result.problem = std::to_string(num_points) + " points do not fit in memory; accepted: fewer";
  } catch (const std::exception& error) {
    result.problem = error.what();
  }
  return result;
}

// With an accuracy target the surface is made in another thread, since its trials may take longer than the user waits.
void CloudWorker::build(CloudWork& work, CloudResult& result) const {
  const simulation::AccuracyParams& accuracy = work.params.accuracy;
  const bool is_tried = accuracy.position_error > 0.0 && !work.has_patience;
  std::unique_ptr<simulation::Simulation> simulation;
  std::optional<simulation::AccuracyChoice> chosen;  // but not found
  if (is_tried) {
    auto choosing = std::make_unique<PendingChoice>(work.params, work.cloud, work.num_threads, [this] { inbox_.wake(); });
    // Another cloud would wait, too; whether it shows another surface is seen once this one is there.
    const bool is_replaceable = work.params.input.policy == simulation::InputPolicy::kReplace;
    const auto ends = [&] { return inbox_.isClosed() || (is_replaceable && hasArrived()); };
    if (choosing->wait(accuracy.patience, ends)) {
      PendingChoice::Made made = choosing->take();
      if (!made.problem.empty() || isFound(made.simulation->accuracyChoice(), accuracy.position_error)) {
        result.problem = std::move(made.problem);
        result.simulation = std::move(made.simulation);
        result.viewer = std::move(made.viewer);
        return;
      }
      chosen = made.simulation->accuracyChoice();
    } else {
      result.choosing = std::move(choosing);
    }
    endIfInterrupted();
    const Index num_cloud = work.cloud.size();
    simulation = std::make_unique<simulation::Simulation>(simulation::Simulation::untried(work.params, std::move(work.cloud)));
    if (chosen) result.trials = sayNotFound(*chosen, accuracy.position_error, simulation->accuracyChoice().points, num_cloud);
  } else {
    simulation = std::make_unique<simulation::Simulation>(work.params, std::move(work.cloud));
  }
  result.viewer = std::make_unique<simulation::Simulation>(simulation->viewer());
  result.simulation = std::move(simulation);
}

}  // namespace deformable_surface::node
