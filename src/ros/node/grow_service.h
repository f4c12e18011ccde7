// The service ~grow_surface, also under its old name ~fit. Growing a surface takes seconds: it is
// done on a copy, in threads of its own. Meanwhile the surface stands still and the node goes on answering.
#pragma once

#include "inbox.h"
#include "queue_thread.h"
#include "stepper.h"
#include "warning_log.h"

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/service_server.h>

#include <functional>
#include <string>
#include <vector>

namespace deformable_surface::node {

class GrowService {
 public:
  GrowService(ros::NodeHandle node, Inbox& inbox, Stepper& stepper, WarningLog& warnings);
  /// To be called after the inbox is closed, which ends running work.
  ~GrowService();

  /// Resolved names, for registering them again.
  std::vector<std::string> names() const { return {server_.getService(), old_server_.getService()}; }

 private:
  /// notice: logged as a warning at each call; empty: none.
  template <class Request, class Response>
  ros::ServiceServer advertise(ros::NodeHandle& node, const std::string& name, const std::string& notice);
  /// Throws.
  template <class Request, class Response>
  void grow(const Request& request, Response& response);
  /// Performs the work however busy the simulation is: the surface is held until it is done.
  void performInTheEnd(const std::function<void()>& work);

  Inbox& inbox_;
  Stepper& stepper_;
  WarningLog& warnings_;
  ros::CallbackQueue queue_;
  ros::ServiceServer server_, old_server_;
  // While one grows a surface, the other refuses calls.
  QueueThread first_thread_, second_thread_;
};

}  // namespace deformable_surface::node
