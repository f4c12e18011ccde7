// Parameters that change while the node runs, as dynamic_reconfigure's clients (rqt_reconfigure, dynparam) know them. The
// descriptions come from the schema of the scene file, so that there is one list of names, units and ranges;
// dynamic_reconfigure's own server would want a second one, in a .cfg file.
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

/// What there is to change: names are the keys of the scene file, with .x, .y and .z for the numbers of a vector.
dynamic_reconfigure::ConfigDescription describeRunTimeParams();
dynamic_reconfigure::Config printRunTimeParams(const simulation::SceneParams& params);
/// The params with the values of the config. Throws InputError, as for a scene file, and for names that are not among those.
simulation::SceneParams readRunTimeParams(const dynamic_reconfigure::Config& config, const simulation::SceneParams& params);

class Reconfigure {
 public:
  Reconfigure(ros::NodeHandle node, Inbox& inbox, Stepper& stepper, WarningLog& warnings);

  /// Tells the listeners what holds now. By the simulation thread.
  void publish();
  /// Writes what is another than last time to the parameter server, so that who looks there, or starts the node again, finds what
  /// holds. Not by the simulation thread, since the server may be away. Calls what onStore() was given, if anything was written.
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
