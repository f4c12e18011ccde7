// What the node publishes after every step: contact wrenches of tools and pins, single contacts, and what became of commands to
// tools. Apart from what is made for the eye (publishers.h), which a thread of its own makes and which may be dropped:
// controllers close their loops over this.
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
  /// on_subscriber is called when somebody begins to listen. The node handle must outlive this.
  WrenchPublishers(ros::NodeHandle& node, const std::function<void()>& on_subscriber);

  /// stamp: ns, of the simulation's state; frame: that of the surface; silent: ids of the tools that are, whose own topics keep
  /// the stamp of before.
  void publish(const simulation::Simulation& simulation, std::int64_t stamp, const std::string& frame,
               const std::set<std::string>& silent);
  void publish(const ToolStatusArray& statuses) { statuses_.publish(statuses); }
  bool isHeard() const;

 private:
  void advertise(const std::vector<tool::ToolParams>& tools);
  bool isContactsDue(double rate, std::int64_t stamp);

  ros::NodeHandle& node_;
  ros::Publisher all_, contacts_, statuses_;
  std::map<std::string, ros::Time> last_heard_of_;  // of tools that are not silent: the stamp of the last state, by id
  std::map<std::string, ros::Publisher> of_tool_;   // by id
  std::chrono::steady_clock::time_point next_try_;  // to advertise
  std::int64_t contacts_turn_ = -1;                 // of output.contacts_rate, in which contacts were published last
};

}  // namespace deformable_surface::node
