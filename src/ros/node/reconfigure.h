// Parameters that may change while the node runs, for the clients of dynamic_reconfigure (rqt_reconfigure, dynparam). The
// descriptions come from the schema of the scene file: there is one list of names, units and ranges.
// dynamic_reconfigure's own server would need a second one, in a .cfg file.
#pragma once

#include "inbox.h"
#include "stepper.h"
#include "warning_log.h"

#include "deformable_surface/simulation/run_time_params.h"

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/service_server.h>

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <utility>

namespace deformable_surface::node {

/// The parameters that may change: names are the keys of the scene file, with .x, .y and .z for the numbers of a vector.
dynamic_reconfigure::ConfigDescription describeRunTimeParams();
dynamic_reconfigure::Config printRunTimeParams(const simulation::SceneParams& params);
/// The params with the values of the config. Throws InputError, as for a scene file, and for unknown names.
simulation::SceneParams readRunTimeParams(const dynamic_reconfigure::Config& config, const simulation::SceneParams& params);

class Reconfigure {
 public:
  Reconfigure(ros::NodeHandle node, Inbox& inbox, Stepper& stepper, WarningLog& warnings);

  /// Publishes the present values. For the simulation thread.
  void publish();
  /// Writes changed values to the parameter server, so that readers of the server, or a restarted node, find the present
  /// values. Not for the simulation thread: the server may not answer. Calls what onStore() was given, if anything was written.
  void store();
  void onStore(std::function<void()> call) { on_store_ = std::move(call); }
  std::string serviceName() const { return server_.getService(); }

 private:
  bool set(const dynamic_reconfigure::Config& wanted, dynamic_reconfigure::Config& now);
  std::map<std::string, double> listValues();

  ros::NodeHandle node_;
  std::function<void()> on_store_;
  std::mutex mutex_;
  dynamic_reconfigure::Config last_;      // published
  std::map<std::string, double> stored_;  // on the parameter server, flags as 0 and 1
  Inbox& inbox_;
  Stepper& stepper_;
  WarningLog& warnings_;
  ros::Publisher descriptions_, updates_;
  ros::ServiceServer server_;
};

}  // namespace deformable_surface::node
