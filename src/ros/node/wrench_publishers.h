// Publishes after every step: contact wrenches of tools and pins, single contacts, and results of commands to
// tools. Controllers close their loops over this. Outputs for display (publishers.h) have a thread of their own and may
// be dropped.
#pragma once

#include "deformable_surface/ToolStatusArray.h"
#include "deformable_surface/simulation/simulation.h"

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <chrono>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace deformable_surface::node {

/// For the stepping thread.
class WrenchPublishers {
 public:
  /// on_subscriber is called when a subscriber appears. The node handle must outlive this.
  WrenchPublishers(ros::NodeHandle& node, const std::function<void()>& on_subscriber);

  /// stamp: ns, of the simulation's state; frame: of the surface; silent: ids of the silent tools; their own topics keep
  /// the former stamp.
  void publish(const simulation::Simulation& simulation, std::int64_t stamp, const std::string& frame,
               const std::set<std::string>& silent);
  void publish(const ToolStatusArray& statuses) { statuses_.publish(statuses); }
  bool hasSubscribers() const;

 private:
  void advertise(const std::vector<tool::ToolParams>& tools);
  bool isContactsDue(double rate, std::int64_t stamp);

  ros::NodeHandle& node_;
  ros::Publisher all_, contacts_, statuses_;
  std::map<std::string, ros::Time> last_stamps_;    // of tools that are not silent: the stamp of the last state, by id
  std::map<std::string, ros::Publisher> of_tool_;   // by id
  std::chrono::steady_clock::time_point next_try_;  // to advertise
  std::int64_t contacts_turn_ = -1;                 // of output.contacts_rate, in which contacts were published last
};

}  // namespace deformable_surface::node
