// The thread for slow work on clouds: it decodes them, builds surfaces from them, and prepares them for tracking,
// while the stepping thread goes on. The two threads share only this: the newest cloud that came, one
// piece of work, one result.
#pragma once

#include "inbox.h"
#include "pending_choice.h"
#include "warning_log.h"

#include "deformable_surface/ros/convert/cloud_decoder.h"
#include "deformable_surface/simulation/observed_cloud.h"
#include "deformable_surface/simulation/simulation.h"

#include <Eigen/Geometry>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace deformable_surface::node {

/// What to make of a cloud.
struct CloudWork {
  enum class Kind { kBuild, kObserve };
  Kind kind = Kind::kBuild;
  cloud::PointCloud cloud;
  std::int64_t stamp = 0, arrival = 0;                          // ns
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();  // T_surface_cloud
  std::string frame, cloud_frame;                               // of the surface; of the message
  simulation::SceneParams params;                               // to build with
  int num_threads = 1;                                          // of the loops over its points; >= 1
  bool has_patience = true;  // it waits to the end of trials for an accuracy target, whatever accuracy.patience is
};

/// The result.
struct CloudResult {
  std::int64_t stamp = 0, arrival = 0;  // ns
  std::string frame, cloud_frame;
  std::string problem;  // one sentence; empty: it was accepted, and the requested one of these is there:
  std::unique_ptr<simulation::Simulation> simulation, viewer;
  std::shared_ptr<const simulation::ObservedCloud> observed;
  // For a simulation whose cloud was filtered: notices, and the cloud before the filters, in the surface's frame.
  std::vector<std::string> filter_notices;
  std::unique_ptr<cloud::PointCloud> unfiltered;
  // For a simulation that is untried (Simulation::untried()): the one that trials still choose for; else null.
  std::unique_ptr<PendingChoice> choosing;
  // For one that is untried since trials did not find a number of points: what they found.
  std::string trials;
};

class CloudWorker {
 public:
  CloudWorker(Inbox& inbox, WarningLog& warnings, const DecodeLimits& limits);
  /// To be called after the inbox is closed, which ends running work.
  ~CloudWorker();
  CloudWorker(const CloudWorker&) = delete;
  CloudWorker& operator=(const CloudWorker&) = delete;

  /// From any thread: a cloud that came. It is decoded and put into the inbox when there is no other work. Of clouds that come
  /// meanwhile the newest is kept.
  void put(const boost::shared_ptr<const BoundedCloud>& message);
  /// Numbers of clouds that came; that were replaced by newer ones; that were not even decoded, because clouds are ignored.
  struct Counts {
    int received = 0, replaced = 0, ignored = 0;
  };
  Counts counts() const;

  // From the stepping thread.
  /// Whether clouds are ignored from now on.
  void ignore(bool is_ignoring);
  /// Whether work is running, or a result was not taken.
  bool isBusy() const;
  /// Only if it is not busy.
  void begin(CloudWork&& work);
  /// None if there is no result (yet). A result wakes the inbox.
  std::optional<CloudResult> take();

 private:
  struct Arrived {
    boost::shared_ptr<const BoundedCloud> message;
    std::int64_t arrival = 0;
  };

  void run();
  void decode(const Arrived& arrived);
  CloudResult carryOut(CloudWork& work) const;
  void build(CloudWork& work, CloudResult& result) const;
  bool hasArrived() const;

  Inbox& inbox_;
  WarningLog& warnings_;
  const DecodeLimits limits_;
  mutable std::mutex mutex_;
  std::condition_variable came_;
  std::optional<Arrived> arrived_;
  std::optional<CloudWork> work_;
  std::optional<CloudResult> result_;
  bool is_busy_ = false, is_ignoring_ = false, is_ended_ = false;
  Counts counts_;
  std::thread thread_;
};

}  // namespace deformable_surface::node
