// What the node publishes of its surface. Each output is made only for those who listen, as a message of its own that is never
// changed again, so that nodelets in the same process share it without a copy.
#pragma once

#include "deformable_surface/ros/encode.h"
#include "deformable_surface/ros/markers.h"
#include "deformable_surface/simulation/simulation.h"

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace deformable_surface::node {

class Publishers {
 public:
  /// on_subscriber is called when somebody begins to listen. The node handle must outlive this.
  Publishers(ros::NodeHandle& node, const std::function<void()>& on_subscriber);

  /// A new surface, which must be at rest.
  void begin(const simulation::Simulation& simulation, const std::string& frame);
  /// The simulation's output.normals may have changed.
  void setNormals(const simulation::Simulation& simulation);
  /// Publishes the surface as it is now. time_input: seconds spent on commands in the last step, for the statistics. all: clouds and
  /// markers too that have not changed since they were published.
  void publish(simulation::Simulation& simulation, std::int64_t stamp, double time_input, bool all);
  /// Publishes what tools and pins feel: after every step, since controllers close their loops over it.
  void publishWrenches(const simulation::Simulation& simulation, std::int64_t stamp);
  /// Whether anybody listens to what is published after every step.
  bool hasStepListeners() const;
  bool isStatisticsHeard() const { return statistics_.getNumSubscribers() > 0; }

 private:
  std_msgs::Header makeHeader(std::int64_t stamp) const;
  void advertiseWrenches(const std::vector<tool::ToolParams>& tools);

  ros::NodeHandle& node_;
  ros::Publisher deformed_, simulation_points_, markers_, statistics_, tool_wrenches_;
  std::map<std::string, ros::Publisher> wrenches_;  // of each tool, by id
  std::chrono::steady_clock::time_point next_try_;  // to advertise
  std::string frame_;
  std::optional<SurfaceEncoder> encoder_;
  std::optional<SimulationMarkers> marker_maker_;
  MarkerNews marker_news_;
  std::atomic<bool> is_viewer_new_{false};           // of the markers: it has nothing yet
  std::chrono::steady_clock::time_point next_full_;  // all markers again
  bool is_new_ = false;        // nothing of this surface was published yet
  std::uint64_t surface_revision_ = 0, points_revision_ = 0, markers_revision_ = 0;  // of the simulation, when published last
  double time_publish_ = 0.0;  // s, of the last frame
};

}  // namespace deformable_surface::node
