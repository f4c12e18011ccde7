// The service ~grow_surface, also under its old name, ~fit. Apart from the others because growing a surface takes seconds: it is
// done on a copy, in threads of its own, while the surface stands and the node goes on answering.
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
  /// After the inbox is closed, which ends what is under way.
  ~GrowService();

  /// Resolved, for registering them again.
  std::vector<std::string> names() const { return {server_.getService(), old_server_.getService()}; }

 private:
  /// notice: what each call is told by a warning; empty: nothing.
  template <class Request, class Response>
  ros::ServiceServer advertise(ros::NodeHandle& node, const std::string& name, const std::string& notice);
  /// Throws.
  template <class Request, class Response>
  void grow(const Request& request, Response& response);
  void perform(const std::function<void()>& work);
  /// However busy the simulation is: it must come to it, for the surface is held until then.
  void performInTheEnd(const std::function<void()>& work);

  Inbox& inbox_;
  Stepper& stepper_;
  WarningLog& warnings_;
  ros::CallbackQueue queue_;
  ros::ServiceServer server_, old_server_;
  // One grows a surface while the other refuses to.
  QueueThread first_thread_, second_thread_;
};

}  // namespace deformable_surface::node
