// The treatment of clouds: which one is decoded next for a surface or for tracking, when it is used, and which are
// ignored. Steps go on meanwhile: the worker does what takes long.
#include "stepper.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/equal_clouds.h"
#include "deformable_surface/ros/convert/frames.h"
#include "deformable_surface/simulation/run_time_params.h"

#include <ros/console.h>

#include <algorithm>
#include <utility>

#include "few_clouds.h"

namespace deformable_surface::node {
namespace {

// A simulated clock may start late or jump; steps do not catch up from a cloud that is older than this when it comes.
constexpr std::int64_t kOldCloud = 1'000'000'000;
// The stamp of a cloud is that of its surface at rest while tf2 and RViz, which keep ten seconds, surely know its transforms.
constexpr std::int64_t kLongestBuild = 5'000'000'000;
constexpr double kLongBuild = 2.0;  // s: a longer wait needs a message

double secondsSince(Inbox::SteadyTime then) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

}  // namespace

bool Stepper::isTracking() const { return simulation_ && params_.input.policy == simulation::InputPolicy::kTrack; }

std::int64_t Stepper::arrivalOf(const IncomingCloud& incoming) const {
  return incoming.arrival != 0 ? incoming.arrival : now_ + delay_;
}

std::int64_t Stepper::stampOf(const IncomingCloud& incoming) const {
  const ros::Time stamp = incoming.decoded.header.stamp;
  return stamp.isZero() ? arrivalOf(incoming) : static_cast<std::int64_t>(stamp.toNSec());
}

void Stepper::handleClouds() {
  if (std::optional<CloudResult> result = worker_.take()) takeResult(std::move(*result));
  if (isTracking()) observeReady();
  if (simulation_ && params_.input.policy == simulation::InputPolicy::kIgnore) {
    counts_.clouds_ignored += static_cast<int>(clouds_.size());
    clouds_.clear();
  }
  if (clouds_.isEmpty() || worker_.isBusy()) return;
  CloudWork work;
  std::optional<IncomingCloud> incoming =
      clouds_.take([&](const IncomingCloud& cloud, bool is_patient) { return prepare(cloud, is_patient, work); });
  if (!incoming) return;
  work.kind = isTracking() ? CloudWork::Kind::kObserve : CloudWork::Kind::kBuild;
  work.arrival = arrivalOf(*incoming);
  work.stamp = stampOf(*incoming);
  work.cloud_frame = incoming->decoded.header.frame_id;
  work.cloud = std::move(incoming->decoded.cloud);
  work.params = params_;
  // The steps of the present surface go on meanwhile.
  work.has_patience = is_clock_simulated_ || isLockstep() || is_paused_;
  work.num_threads = simulation_ ? std::max(1, numThreads() / 2) : numThreads();
  if (work.kind == CloudWork::Kind::kBuild) {
    built_revision_ = params_revision_;
    if (!simulation_) setSurfaceFrame(work.frame);
    if (simulation_) commands_.keepSince(work.stamp);  // without a surface they wait for it anyway
    if (isAgain(work)) return begin({work.stamp, work.arrival, frame_, work.cloud_frame, {}, {}, {}, {}, {}, {}, {}, {}});
    building_ = Building{std::chrono::steady_clock::now(), work.cloud.size()};
  }
  worker_.begin(std::move(work));
}

/// Finds the transform into the surface's frame, if it is known now.
WaitingClouds::Answer Stepper::prepare(const IncomingCloud& incoming, bool is_patient, CloudWork& work) {
  const std_msgs::Header& header = incoming.decoded.header;
  const std::int64_t ahead = stampOf(incoming) - arrivalOf(incoming);
  try {
    if (ahead > kMaxAhead) {
      throw InputError("header.stamp: found a time " + formatReal(toSeconds(ahead)) + " s ahead of the clock; accepted: up to " +
                       formatReal(toSeconds(kMaxAhead)) + " s");
    }
    work.frame = isTracking() ? frame_ : withoutSlash(params_.frame_id.empty() ? header.frame_id : params_.frame_id);
    work.transform = findTransform("header.frame_id", header.frame_id, work.frame, header.stamp, transforms_);
    return WaitingClouds::Answer::kTake;
  } catch (const FrameError& error) {
    if (is_patient) {
      warnings_.report(Warning::kWaiting, std::string("cloud: ") + error.what() + "; the cloud waits for it");
      return WaitingClouds::Answer::kWait;
    }
    warnings_.report(Warning::kCloudRefused, std::string("cloud refused: ") + error.what());
  } catch (const InputError& error) {
    warnings_.report(Warning::kCloudRefused, std::string("cloud refused: ") + error.what());
  }
  return WaitingClouds::Answer::kRefuse;
}

void Stepper::takeResult(CloudResult&& result) {
  if (!result.problem.empty()) {
    building_.reset();
    commands_.forgetKept();
    warnings_.report(Warning::kCloudRefused, "cloud refused: " + result.problem);
  } else if (result.simulation) {
    begin(std::move(result));
  } else if (isTracking() && result.frame == frame_) {
    ready_.push_back({result.stamp, std::move(result.observed)});
    counts_.clouds_dropped += dropOldestClouds(ready_, [](const ReadyCloud& ready) { return ready.cloud->points().size(); });
  }
}

void Stepper::setSurfaceFrame(const std::string& frame) {
  inbox_.setSurfaceFrame(frame);
  commands_.setSurfaceFrame(frame);
}

// Once, so that the node does not seem dead.
void Stepper::reportBuilding() {
  if (!building_ || building_->is_reported || !(secondsSince(building_->begin) > kLongBuild)) return;
  building_->is_reported = true;
  ROS_INFO_STREAM(warnings_.name() << ": a surface of " << building_->points << " points has been under construction for "
                                   << formatShort(secondsSince(building_->begin)) << " s"
                                   << (simulation_ ? "; the one before goes on meanwhile" : ""));
}

// A cloud shows the surface at its stamp, and is tracked from there on.
void Stepper::observeReady() {
  if (hold_.isActive()) return;
  const std::uint64_t step = simulation_->stepCount();
  const auto isDue = [&](const ReadyCloud& ready) { return isPaused() || ready.stamp <= schedule_.begin(step); };
  const auto newest = std::find_if(ready_.rbegin(), ready_.rend(), isDue);
  if (newest == ready_.rend()) return;
  try {
    simulation_->observe(newest->cloud);
    tracking_.see(static_cast<Index>(simulation_->statistics().tracked_points));
    ++counts_.clouds_tracked;
    counts_.clouds_late += !isPaused() && step > 0 && newest->stamp <= schedule_.begin(step - 1);
  } catch (const InputError& error) {
    warnings_.report(Warning::kCloudRefused, std::string("cloud refused: ") + error.what());
  }
  counts_.clouds_dropped += static_cast<int>(ready_.rend() - newest) - 1;
  ready_.erase(ready_.begin(), newest.base());
}

// Whether neighbours, weights and springs would come out the same.
bool Stepper::isAgain(const CloudWork& work) const {
  return simulation_ && is_as_built_ && work.frame == frame_ && work.transform.isApprox(Eigen::Isometry3d::Identity(), 0.0) &&
         cloud::areEqual(work.cloud, unfiltered_ ? *unfiltered_ : simulation_->input());
}

void Stepper::adopt(std::unique_ptr<simulation::Simulation> simulation, std::unique_ptr<simulation::Simulation> viewer,
                    std::uint64_t params_revision) {
  simulation_ = std::move(simulation);
  new_viewer_ = std::move(viewer);
  simulation_->setInterrupt(inbox_.endingStep());
  // Values that may change at run time may have changed while this surface was built.
  if (params_revision_ != params_revision) simulation_->setParams(simulation::withRunTimeValues(simulation_->params(), params_));
}

// With the simulation that was built or, if none was, with the present one.
void Stepper::begin(CloudResult&& result) {
  const bool is_again = !result.simulation;
  // Commands for the surface before are not for this one, except those since its stamp. Before the first surface there was no
  // other that they could be for.
  if (simulation_) {
    tellWhatLasted();
    commands_.takeBack();
    commands_.dropBefore(result.stamp);
  }
  if (is_again) {
    resetSurface();
  } else {
    adopt(std::move(result.simulation), std::move(result.viewer), built_revision_);
    unfiltered_ = std::move(result.unfiltered);
    choosing_ = std::move(result.choosing);
    chosen_revision_ = built_revision_;
    chosen_.reset();
    trials_ = std::move(result.trials);
  }
  is_as_built_ = true;
  frame_ = result.frame;
  setSurfaceFrame(frame_);
  snapshots_.clear();
  beginAnew(result.stamp);
  if (is_clock_simulated_ && result.arrival - result.stamp > kOldCloud) skipTo(delayed(result.arrival), 0);
  updateGravity();
  ++counts_.clouds_accepted;
  counts_.clouds_again += is_again;
  cloud_.number = static_cast<std::uint32_t>(counts_.clouds_accepted);
  cloud_.stamp.fromNSec(static_cast<std::uint64_t>(result.stamp));
  cloud_.frame = result.cloud_frame;
  worker_.ignore(params_.input.policy == simulation::InputPolicy::kIgnore);

  std::string notice = ": the same cloud was received again: its surface is reset to its rest state";
  if (!is_again) {
    std::string notices;
    for (const std::string& more : result.filter_notices) appendNotice(notices, more);
    for (const std::string& more : simulation_->buildNotes()) appendNotice(notices, more);
    notice = ": surface built in " + formatShort(secondsSince(building_->begin)) + " s: " + notices;
  }
  const std::int64_t behind = is_clock_simulated_ || isLockstep() ? 0 : delayed(inbox_.now()) - schedule_.begin(0);
  if (choosing_) notice += "; trials for accuracy.position_error go on in the background (accuracy.patience)";
  if (behind > kMaxLag)
    notice +=
        "; it begins " + formatShort(toSeconds(behind)) + " s after the stamp of its cloud, and does not catch up with that time";
  ROS_INFO_STREAM(warnings_.name() << notice);
  for (const std::string& warning : simulation_->buildWarnings()) warnings_.report(Warning::kNotice, warning);
  if (!trials_.empty() && !is_again) warnings_.report(Warning::kNotice, trials_);
  building_.reset();
  // At rest it is the cloud itself, at the cloud's stamp.
  show(inbox_.now() - result.stamp <= kLongestBuild ? result.stamp : outputStamp());
}

}  // namespace deformable_surface::node
