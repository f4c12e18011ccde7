// The part of RViz in tests of the interactive markers: it sends the feedback that RViz sends when a person drags a marker or
// chooses from a menu.
#pragma once

#include "../node_process.h"

#include "deformable_surface/base/types.h"

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <visualization_msgs/InteractiveMarkerFeedback.h>
#include <visualization_msgs/InteractiveMarkerInit.h>
#include <visualization_msgs/InteractiveMarkerUpdate.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <map>
#include <string>

namespace deformable_surface::node::test {

/// The markers as RViz has them, and the actions of a person in RViz.
class FakeRviz {
  using Feedback = visualization_msgs::InteractiveMarkerFeedback;

 public:
  /// server: the node of the markers. frame: of the surface.
  FakeRviz(const std::string& server, const std::string& frame)
      : frame_(frame),
        init_(node_.subscribe<visualization_msgs::InteractiveMarkerInit>(
            server + "/update_full", 100,
            [this](const visualization_msgs::InteractiveMarkerInitConstPtr& m) {
              for (const auto& marker : m->markers) markers[marker.name] = marker;
            })),
        update_(node_.subscribe<visualization_msgs::InteractiveMarkerUpdate>(
            server + "/update", 100,
            [this](const visualization_msgs::InteractiveMarkerUpdateConstPtr& m) {
              for (const auto& marker : m->markers) markers[marker.name] = marker;
              for (const auto& pose : m->poses) markers[pose.name].pose = pose.pose;
              for (const auto& name : m->erases) markers.erase(name);
              num_updates += m->type == visualization_msgs::InteractiveMarkerUpdate::UPDATE;
            })),
        feedback_(node_.advertise<Feedback>(server + "/feedback", 100)) {}

  bool waitForMarker(const std::string& name) {
    return waitUntil([&] { return markers.count(name) > 0 && feedback_.getNumSubscribers() > 0; });
  }

  void press(const std::string& marker, const Vec3& handle, const Vec3& mouse) {
    Feedback feedback = makeFeedback(marker, Feedback::MOUSE_DOWN, handle);
    feedback.mouse_point.x = mouse.x(), feedback.mouse_point.y = mouse.y(), feedback.mouse_point.z = mouse.z();
    feedback.mouse_point_valid = true;
    feedback_.publish(feedback);
  }
  void drag(const std::string& marker, const Vec3& handle, const Eigen::Quaterniond& turn = Eigen::Quaterniond::Identity()) {
    Feedback feedback = makeFeedback(marker, Feedback::POSE_UPDATE, handle);
    feedback.pose.orientation.w = turn.w(), feedback.pose.orientation.x = turn.x();
    feedback.pose.orientation.y = turn.y(), feedback.pose.orientation.z = turn.z();
    feedback_.publish(feedback);
  }
  void release(const std::string& marker, const Vec3& handle) {
    feedback_.publish(makeFeedback(marker, Feedback::MOUSE_UP, handle));
  }
  void choose(const std::string& marker, const std::string& title) {
    Feedback feedback = makeFeedback(marker, Feedback::MENU_SELECT, Vec3::Zero());
    const auto& entries = markers.at(marker).menu_entries;
    const auto found = std::find_if(entries.begin(), entries.end(), [&](const auto& entry) { return entry.title == title; });
    ASSERT_NE(found, entries.end()) << title;
    feedback.pose = markers.at(marker).pose;
    feedback.menu_entry_id = found->id;
    feedback_.publish(feedback);
  }
  /// The sentence beside the panel.
  visualization_msgs::Marker findAnswer() {
    for (const auto& control : markers["panel"].controls)
      for (const auto& marker : control.markers)
        if (marker.type == visualization_msgs::Marker::TEXT_VIEW_FACING) return marker;
    return {};
  }
  bool offers(const std::string& marker, const std::string& title) {
    const auto& entries = markers.at(marker).menu_entries;
    return std::any_of(entries.begin(), entries.end(), [&](const auto& entry) { return entry.title == title; });
  }

  std::map<std::string, visualization_msgs::InteractiveMarker> markers;
  int num_updates = 0;

 private:
  Feedback makeFeedback(const std::string& marker, std::uint8_t event, const Vec3& handle) {
    Feedback feedback;
    feedback.header.frame_id = frame_;
    feedback.client_id = "fake_rviz";
    feedback.marker_name = marker;
    feedback.event_type = event;
    feedback.pose.position.x = handle.x(), feedback.pose.position.y = handle.y(), feedback.pose.position.z = handle.z();
    feedback.pose.orientation.w = 1.0;
    return feedback;
  }

  ros::NodeHandle node_;
  const std::string frame_;
  ros::Subscriber init_, update_;
  ros::Publisher feedback_;
};

}  // namespace deformable_surface::node::test
