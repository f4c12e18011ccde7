// The service ~fit. Apart from the others because growing a surface takes seconds: it is done on a copy, in threads of its own,
// while the surface stands and the node goes on answering.
#pragma once

#include "inbox.h"
#include "queue_thread.h"
#include "stepper.h"
#include "warning_log.h"

#include "deformable_surface/FitSurface.h"

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/service_server.h>

#include <functional>
#include <string>

namespace deformable_surface::node {

class FitService {
 public:
  FitService(ros::NodeHandle node, Inbox& inbox, Stepper& stepper, WarningLog& warnings);
  /// After the inbox is closed, which ends a fit that is under way.
  ~FitService();

  /// Resolved, for registering it again.
  std::string name() const { return server_.getService(); }

 private:
  /// Throws.
  void fit(const FitSurfaceRequest& request, FitSurfaceResponse& response);
  void perform(const std::function<void()>& work);
  /// However busy the simulation is: it must come to it, for the surface is held until then.
  void performInTheEnd(const std::function<void()>& work);

  Inbox& inbox_;
  Stepper& stepper_;
  WarningLog& warnings_;
  ros::CallbackQueue queue_;
  ros::ServiceServer server_;
  // One grows a surface while the other refuses to.
  QueueThread first_thread_, second_thread_;
};

}  // namespace deformable_surface::node
