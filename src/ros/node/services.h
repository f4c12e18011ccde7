// The services of the node. Each hands its work to the simulation thread and waits for the answer. None throws.
#pragma once

#include "inbox.h"
#include "stepper.h"
#include "warning_log.h"

#include "deformable_surface/EditParticles.h"
#include "deformable_surface/List.h"
#include "deformable_surface/Restore.h"
#include "deformable_surface/SaveCloud.h"
#include "deformable_surface/SelectRegion.h"
#include "deformable_surface/SetMaterial.h"
#include "deformable_surface/Snapshot.h"
#include "deformable_surface/Step.h"

#include <ros/node_handle.h>
#include <ros/service_server.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace deformable_surface::node {

class Services {
 public:
  /// reset_node: with a queue of its own, since a reset ends work that other calls wait for. save_directory: absolute, existing;
  /// empty = ~save is off.
  Services(ros::NodeHandle& node, ros::NodeHandle& reset_node, Inbox& inbox, Stepper& stepper, const tf2::BufferCore& transforms,
           WarningLog& warnings, std::string save_directory);

  /// call: called after ~restore, by the thread that answers it.
  void onRestore(std::function<void()> call) { on_restore_ = std::move(call); }
  /// Resolved names, for registering them again.
  std::vector<std::string> names() const;

 private:
  /// Lets the simulation thread do the work, which returns the message of success. Failures give success = false and the reason.
  template <class Response, class Work>
  bool perform(Response& response, const Work& work, bool ends_step = false);

  bool reset(std_srvs::TriggerResponse& response);
  bool pause(bool paused, std_srvs::SetBoolResponse& response);
  bool step(std::uint32_t count, StepResponse& response);
  bool select(const SelectRegionRequest& request, bool pinned, SelectRegionResponse& response);
  bool edit(const EditParticlesRequest& request, EditParticlesResponse& response);
  bool save(const std::string& name, SaveCloudResponse& response);
  bool keep(const SnapshotRequest& request, SnapshotResponse& response);
  bool restore(const std::string& name, RestoreResponse& response);
  bool list(ListResponse& response);
  bool setMaterial(const SetMaterialRequest& request, SetMaterialResponse& response);

  Inbox& inbox_;
  Stepper& stepper_;
  const tf2::BufferCore& transforms_;
  WarningLog& warnings_;
  const std::string save_directory_;
  std::function<void()> on_restore_;
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace deformable_surface::node
