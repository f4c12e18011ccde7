#include "publishers.h"

#include "deformable_surface/Statistics.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/ros/surface_output.h"

#include <boost/make_shared.hpp>

namespace deformable_surface::node {
namespace {

template <class Message>
boost::shared_ptr<Message> makeMessage(const std_msgs::Header& header) {
  auto message = boost::make_shared<Message>();
  message->header = header;
  return message;
}

boost::shared_ptr<sensor_msgs::PointCloud2> makeSimulationPoints(const std_msgs::Header& header,
                                                                 const simulation::Simulation& simulation) {
  auto message = makeMessage<sensor_msgs::PointCloud2>(header);
  encodeSimulationPoints(simulation, *message);
  return message;
}

// Arrows of the surface before would stay in RViz for ever.
visualization_msgs::Marker makeDeleteAll(const std_msgs::Header& header) {
  visualization_msgs::Marker marker;
  marker.header = header;
  marker.action = visualization_msgs::Marker::DELETEALL;
  marker.pose.orientation.w = 1.0;
  return marker;
}

}  // namespace

Publishers::Publishers(ros::NodeHandle& node, const std::function<void()>& on_subscriber) {
  const ros::SubscriberStatusCallback connected = [on_subscriber](const ros::SingleSubscriberPublisher&) { on_subscriber(); };
  const ros::SubscriberStatusCallback disconnected = [](const ros::SingleSubscriberPublisher&) {};
  const ros::VoidConstPtr untracked;
  // One message waits for a slow listener; it is replaced by the next.
  deformed_ = node.advertise<sensor_msgs::PointCloud2>("deformed", 1, connected, disconnected, untracked, true);
  simulation_points_ = node.advertise<sensor_msgs::PointCloud2>("simulation_points", 1, connected, disconnected);
  markers_ = node.advertise<visualization_msgs::MarkerArray>("markers", 1, connected, disconnected);
  // Statistics are small, and a gap in them is seen in every plot.
  statistics_ = node.advertise<Statistics>("statistics", 100, connected, disconnected);
}

void Publishers::begin(const simulation::Simulation& simulation, const std::string& frame) {
  frame_ = frame;
  encoder_.emplace(simulation.input(), simulation.params().output.normals);
  marker_maker_.emplace(simulation);
  is_new_ = true;
}

void Publishers::publish(simulation::Simulation& simulation, std::int64_t stamp, double time_input) {
  const Timer timer;
  std_msgs::Header header;
  header.stamp.fromNSec(static_cast<std::uint64_t>(stamp));
  header.frame_id = frame_;

  // The first is kept for those who come later.
  if (is_new_ || deformed_.getNumSubscribers() > 0) {
    auto message = makeMessage<sensor_msgs::PointCloud2>(header);
    encoder_->encode(simulation.surface(true), *message);
    deformed_.publish(message);
  }
  if (simulation_points_.getNumSubscribers() > 0) simulation_points_.publish(makeSimulationPoints(header, simulation));
  if (markers_.getNumSubscribers() > 0) {
    auto message = boost::make_shared<visualization_msgs::MarkerArray>();
    marker_maker_->make(header, simulation, *message);
    if (is_new_) message->markers.insert(message->markers.begin(), makeDeleteAll(header));
    markers_.publish(message);
  }
  if (statistics_.getNumSubscribers() > 0) {
    auto message = makeMessage<Statistics>(header);
    encodeStatistics(simulation.statistics(), *message);
    message->time_input = time_input;
    message->time_publish = time_publish_;
    statistics_.publish(message);
  }
  is_new_ = false;
  time_publish_ = timer.seconds();
}

}  // namespace deformable_surface::node
