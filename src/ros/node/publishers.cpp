#include "publishers.h"

#include "deformable_surface/DeformedUpdate.h"
#include "deformable_surface/Statistics.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/ros/convert/surface_output.h"

#include <boost/make_shared.hpp>

#include <utility>

namespace deformable_surface::node {
namespace {

// Statistics are small, and a gap in them is seen in every plot.
constexpr std::uint32_t kStatisticsQueue = 100;
// A namespace that is switched on in RViz appears after this time, even without a change.
constexpr std::chrono::seconds kMarkersPeriod(1);

// A lost update is repaired after this time. Messages are lost so rarely that the whole cloud need not come more
// often.
constexpr std::chrono::seconds kWholeUpdatePeriod(5);
constexpr std::uint32_t kUpdatesQueue = 10;

// Without it, arrows of the last surface would stay in RViz.
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
  // One message waits for a slow subscriber; the next replaces it. Latched for the second subscriber of a process: roscpp
  // gives it what the first one got, without asking here.
  deformed_ = node.advertise<sensor_msgs::PointCloud2>("deformed", 1, connected, ros::SubscriberStatusCallback(),
                                                       ros::VoidConstPtr(), true);
  const ros::SubscriberStatusCallback followed = [this, on_subscriber](const ros::SingleSubscriberPublisher&) {
    is_update_wanted_whole_ = true;
    on_subscriber();
  };
  updates_ = node.advertise<DeformedUpdate>("deformed_update", kUpdatesQueue, followed);
  simulation_points_ = node.advertise<sensor_msgs::PointCloud2>("simulation_points", 1, connected);
  // Latched for players of bags, which give late subscribers the last message as it was recorded.
  markers_ = node.advertise<visualization_msgs::MarkerArray>("markers", 1, connected, ros::SubscriberStatusCallback(),
                                                             ros::VoidConstPtr(), true);
  statistics_ = node.advertise<Statistics>("statistics", kStatisticsQueue, connected);
}

std_msgs::Header Publishers::makeHeader(std::int64_t stamp) const {
  std_msgs::Header header;
  header.stamp.fromNSec(static_cast<std::uint64_t>(stamp));
  header.frame_id = frame_;
  return header;
}

// Markers are sent from time to time in any case.
bool Publishers::isWanted(bool has_changed, bool has_moved) const {
  const bool has_surface_subscribers = deformed_.getNumSubscribers() > 0 || updates_.getNumSubscribers() > 0;
  return hasStatisticsSubscribers() || markers_.getNumSubscribers() > 0 || (has_moved && has_surface_subscribers) ||
         (has_changed && simulation_points_.getNumSubscribers() > 0);
}

void Publishers::publish(Moment& moment) {
  const Timer timer;
  const bool is_other = moment.viewer != nullptr;
  if (is_other) {
    viewer_ = std::move(moment.viewer);
    frame_ = std::move(moment.frame);
    marker_maker_.emplace(*viewer_, frame_);
    is_new_ = true;
  }
  viewer_->restore(moment.sight);
  if (moment.params) viewer_->setParams(*moment.params);
  if (is_other || moment.params)
    encoder_.emplace(viewer_->input(), viewer_->params().output.normals, viewer_->params().output.error);

  const std_msgs::Header header = makeHeader(moment.stamp);
  const auto isNew = [all = moment.all || is_new_](std::uint64_t revision, std::uint64_t& published) {
    return std::exchange(published, revision) != revision || all;
  };
  // The first message, and what a call left, are latched for later subscribers.
  const bool is_seen = deformed_.getNumSubscribers() > 0, is_followed = updates_.getNumSubscribers() > 0;
  const bool is_kept = is_new_ || (moment.is_result && moment.surface_revision != latched_revision_);
  if (!is_followed) changes_.forget();
  if (is_new_ || ((is_seen || is_followed) && isNew(moment.surface_revision, surface_revision_)) || is_kept) {
    const auto message = clouds_.take();
    message->header = header;
    encoder_->encode(viewer_->surface(true), *message);
    if (is_seen || is_kept) {
      deformed_.publish(message);
      latched_revision_ = moment.surface_revision;
    }
    if (is_followed) publishUpdate(message);
  }
  if (simulation_points_.getNumSubscribers() > 0 && isNew(moment.revision, points_revision_)) {
    const auto message = boost::make_shared<sensor_msgs::PointCloud2>();
    message->header = header;
    encodeSimulationPoints(*viewer_, *message);
    simulation_points_.publish(message);
  }
  const bool has_changed = isNew(moment.revision, markers_revision_);
  const bool is_due = has_changed || std::chrono::steady_clock::now() >= next_markers_;
  if (markers_.getNumSubscribers() > 0 && is_due) publishMarkers(header);
  if (hasStatisticsSubscribers()) {
    const auto message = boost::make_shared<Statistics>();
    message->header = header;
    encodeStatistics(viewer_->statistics(), moment.cloud, *message);
    message->time_input = moment.time_input;
    message->time_publish = time_publish_;
    statistics_.publish(message);
  }
  is_new_ = false;
  time_publish_ = timer.seconds();
}

void Publishers::publishUpdate(const sensor_msgs::PointCloud2ConstPtr& cloud) {
  const auto now = std::chrono::steady_clock::now();
  const bool whole = is_update_wanted_whole_.exchange(false) || is_new_ || now >= next_whole_update_;
  if (whole) next_whole_update_ = now + kWholeUpdatePeriod;
  const auto message = boost::make_shared<DeformedUpdate>();
  if (changes_.make(cloud, whole, *message)) updates_.publish(message);
}

void Publishers::publishMarkers(const std_msgs::Header& header) {
  next_markers_ = std::chrono::steady_clock::now() + kMarkersPeriod;
  const auto message = boost::make_shared<visualization_msgs::MarkerArray>();
  marker_maker_->make(header, *viewer_, *message);
  if (is_new_) message->markers.insert(message->markers.begin(), makeDeleteAll(header));
  markers_.publish(message);
}

}  // namespace deformable_surface::node
