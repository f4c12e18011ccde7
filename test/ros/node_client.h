// A client of the running node. It uses the node like any other program, and waits for conditions, never for a time. Every test
// with a roscore uses this file.
#pragma once

#include "node_process.h"

#include "deformable_surface/EditParticles.h"
#include "deformable_surface/GrowSurface.h"
#include "deformable_surface/PointForce.h"
#include "deformable_surface/SaveCloud.h"
#include "deformable_surface/SelectRegion.h"
#include "deformable_surface/Statistics.h"
#include "deformable_surface/Step.h"
#include "deformable_surface/base/types.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <cstring>
#include <map>
#include <string>
#include <vector>

namespace deformable_surface::node::test {

/// Topics and services of one node.
class NodeClient {
 public:
  explicit NodeClient(const std::string& name) : handle_(name), name_(name) {
    deformed_ = handle_.subscribe<sensor_msgs::PointCloud2>("deformed", 100, [this](const sensor_msgs::PointCloud2ConstPtr& m) {
      frames.push_back(m);
      stamps[m->header.stamp] = m;
    });
    diagnostics_ = handle_.subscribe<diagnostic_msgs::DiagnosticArray>(
        "/diagnostics", 100, [this](const diagnostic_msgs::DiagnosticArrayConstPtr& m) { take(*m); });
    cloud_ = handle_.advertise<sensor_msgs::PointCloud2>("cloud_in", 10);
    force_ = handle_.advertise<PointForce>("force", 1000);
  }

  /// True when everything is connected.
  bool waitForNode() {
    return waitUntil([this] {
      return deformed_.getNumPublishers() > 0 && cloud_.getNumSubscribers() > 0 && force_.getNumSubscribers() > 0 &&
             ros::service::exists(name_ + "/save", false);
    });
  }

  void publish(const sensor_msgs::PointCloud2& cloud) { cloud_.publish(cloud); }
  void publish(const PointForce& force) { force_.publish(force); }

  /// Waits for the frame of this stamp.
  sensor_msgs::PointCloud2ConstPtr waitForFrame(const ros::Time& stamp) {
    return waitUntil([&] { return stamps.count(stamp) > 0; }) ? stamps[stamp] : nullptr;
  }
  /// Publishes the cloud and waits until it is published again at rest.
  sensor_msgs::PointCloud2ConstPtr exchange(const sensor_msgs::PointCloud2& cloud) {
    stamps.erase(cloud.header.stamp);
    publish(cloud);
    return waitForFrame(cloud.header.stamp);
  }

  /// A value of the diagnostics of this node, by its name; -1 before the first message.
  double diagnostic(const std::string& key) const {
    const auto found = values_.find(key);
    return found == values_.end() ? -1.0 : std::atof(found->second.c_str());
  }
  std::string diagnosticText(const std::string& key) const {
    const auto found = values_.find(key);
    return found == values_.end() ? "" : found->second;
  }
  bool waitForDiagnostic(const std::string& key, double value) {
    return waitUntil([&] { return diagnostic(key) == value; });
  }

  std_srvs::TriggerResponse reset() { return call<std_srvs::Trigger>("reset", std_srvs::TriggerRequest()); }
  std_srvs::SetBoolResponse pause(bool paused) {
    std_srvs::SetBoolRequest request;
    request.data = paused;
    return call<std_srvs::SetBool>("pause", request);
  }
  StepResponse step(std::uint32_t count) {
    StepRequest request;
    request.count = count;
    return call<Step>("step", request);
  }
  SelectRegionResponse select(const char* service, const SelectRegionRequest& request) {
    return call<SelectRegion>(service, request);
  }
  SaveCloudResponse save(const std::string& name) {
    SaveCloudRequest request;
    request.name = name;
    return call<SaveCloud>("save", request);
  }

  EditParticlesResponse edit(const EditParticlesRequest& request) { return call<EditParticles>("edit", request); }
  GrowSurfaceResponse growSurface(const GrowSurfaceRequest& request) { return call<GrowSurface>("grow_surface", request); }

  ros::NodeHandle& handle() { return handle_; }

  std::vector<sensor_msgs::PointCloud2ConstPtr> frames;
  std::map<ros::Time, sensor_msgs::PointCloud2ConstPtr> stamps;  // the last frame of each

 private:
  template <class Service>
  typename Service::Response call(const std::string& service, const typename Service::Request& request) {
    Service exchange;
    exchange.request = request;
    EXPECT_TRUE(ros::service::call(name_ + "/" + service, exchange)) << service;
    return exchange.response;
  }
  void take(const diagnostic_msgs::DiagnosticArray& message) {
    for (const auto& status : message.status) {
      if (status.name.find(name_.substr(1) + ": ") != 0) continue;
      for (const auto& value : status.values) values_[value.key] = value.value;
    }
  }

  ros::NodeHandle handle_;
  const std::string name_;
  ros::Subscriber deformed_, diagnostics_;
  ros::Publisher cloud_, force_;
  std::map<std::string, std::string> values_;
};

/// A float32 or float64 scalar of a point, by the name of its field.
inline double readField(const sensor_msgs::PointCloud2& cloud, std::size_t point, const std::string& name) {
  for (const auto& field : cloud.fields) {
    if (field.name != name) continue;
    const std::uint8_t* bytes = cloud.data.data() + point * cloud.point_step + field.offset;
    if (field.datatype == sensor_msgs::PointField::FLOAT64) {
      double value;
      std::memcpy(&value, bytes, sizeof value);
      return value;
    }
    float value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }
  ADD_FAILURE() << "no field " << name;
  return 0.0;
}

inline Vec3 readPosition(const sensor_msgs::PointCloud2& cloud, std::size_t point) {
  return {readField(cloud, point, "x"), readField(cloud, point, "y"), readField(cloud, point, "z")};
}

inline PointForce makeForce(const std::string& id, const Vec3& point, const Vec3& force, double radius = 0.0,
                            double duration = 0.0) {
  PointForce message;
  message.id = id;
  message.point.x = point.x(), message.point.y = point.y(), message.point.z = point.z();
  message.force.x = force.x(), message.force.y = force.y(), message.force.z = force.z();
  message.radius = radius;
  message.duration = duration;
  return message;
}

}  // namespace deformable_surface::node::test
