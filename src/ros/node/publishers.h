// Publishes the surface for display. Each output is made only if somebody subscribes. A message that a subscriber holds is
// never changed again, so that nodelets in the same process share it without a copy.
#pragma once

#include "moment.h"

#include "deformable_surface/ros/convert/cloud_updates.h"
#include "deformable_surface/ros/convert/encode.h"
#include "deformable_surface/ros/convert/markers.h"
#include "deformable_surface/ros/node/message_pool.h"

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace deformable_surface::node {

class Publishers {
 public:
  /// on_subscriber is called when a subscriber appears. The node handle must outlive this.
  Publishers(ros::NodeHandle& node, const std::function<void()>& on_subscriber);

  // From any thread.
  /// Whether any subscriber would get a message of a moment.
  bool isWanted(bool has_changed, bool has_moved) const;
  bool hasStatisticsSubscribers() const { return statistics_.getNumSubscribers() > 0; }

  // From one.
  void publish(Moment& moment);

 private:
  std_msgs::Header makeHeader(std::int64_t stamp) const;
  void publishUpdate(const sensor_msgs::PointCloud2ConstPtr& cloud);
  void publishMarkers(const std_msgs::Header& header);

  ros::Publisher deformed_, updates_, simulation_points_, markers_, statistics_;
  std::unique_ptr<simulation::Simulation> viewer_;  // of the surface now; null: there is none yet
  std::string frame_;
  std::optional<SurfaceEncoder> encoder_;
  MessagePool<sensor_msgs::PointCloud2> clouds_;
  CloudUpdates changes_;
  std::atomic<bool> is_update_wanted_whole_{false};  // a subscriber of the updates has nothing yet
  std::chrono::steady_clock::time_point next_whole_update_;
  std::optional<SimulationMarkers> marker_maker_;
  std::chrono::steady_clock::time_point next_markers_;                               // even without a change
  bool is_new_ = false;                                                              // nothing of this surface was published yet
  std::uint64_t surface_revision_ = 0, points_revision_ = 0, markers_revision_ = 0;  // of the simulation, when published last
  std::uint64_t latched_revision_ = 0;                                               // of the surface in the latched cloud
  double time_publish_ = 0.0;                                                        // s, of the last frame
};

}  // namespace deformable_surface::node
