#include "publishers.h"

#include "tool_commands.h"
#include "tool_wrenches.h"

#include "deformable_surface/Statistics.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/ros/surface_output.h"

#include <boost/make_shared.hpp>
#include <ros/master.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace deformable_surface::node {
namespace {

// As many frames as a viewer may be behind.
constexpr std::uint32_t kMarkersQueue = 10;
// Who switches a namespace on in RViz sees it after this, though nothing changes.
constexpr std::chrono::seconds kFullPeriod(1);
// As of the statistics.
constexpr std::uint32_t kWrenchQueue = 100;
// How often a master that is away is looked for.
constexpr std::chrono::seconds kMasterPatience(1);

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

Publishers::Publishers(ros::NodeHandle& node, const std::function<void()>& on_subscriber)
    : node_(node) {
  const ros::SubscriberStatusCallback connected = [on_subscriber](const ros::SingleSubscriberPublisher&) { on_subscriber(); };
  const ros::SubscriberStatusCallback disconnected = [](const ros::SingleSubscriberPublisher&) {};
  const ros::VoidConstPtr untracked;
  // One message waits for a slow listener; it is replaced by the next.
  deformed_ = node.advertise<sensor_msgs::PointCloud2>("deformed", 1, connected, disconnected, untracked, true);
  simulation_points_ = node.advertise<sensor_msgs::PointCloud2>("simulation_points", 1, connected, disconnected);
  // Queued, since each says only what has changed.
  const ros::SubscriberStatusCallback shown = [this, on_subscriber](const ros::SingleSubscriberPublisher&) {
    is_viewer_new_ = true;
    on_subscriber();
  };
  markers_ = node.advertise<visualization_msgs::MarkerArray>("markers", kMarkersQueue, shown, disconnected);
  // Statistics are small, and a gap in them is seen in every plot.
  statistics_ = node.advertise<Statistics>("statistics", 100, connected, disconnected);
  // As small, and a controller may close its loop over them.
  tool_wrenches_ = node.advertise<ToolWrenchArray>("tool_wrenches", 100, connected, disconnected);
}

void Publishers::begin(const simulation::Simulation& simulation, const std::string& frame) {
  frame_ = frame;
  encoder_.emplace(simulation.input(), simulation.params().output.normals);
  marker_maker_.emplace(simulation);
  is_new_ = true;
}

void Publishers::setNormals(const simulation::Simulation& simulation) {
  encoder_.emplace(simulation.input(), simulation.params().output.normals);
}

std_msgs::Header Publishers::makeHeader(std::int64_t stamp) const {
  std_msgs::Header header;
  header.stamp.fromNSec(static_cast<std::uint64_t>(stamp));
  header.frame_id = frame_;
  return header;
}

void Publishers::publish(simulation::Simulation& simulation, std::int64_t stamp, double time_input, bool all) {
  const Timer timer;
  const std_msgs::Header header = makeHeader(stamp);
  all = all || is_new_;
  const auto isNews = [all](std::uint64_t revision, std::uint64_t& published) {
    return std::exchange(published, revision) != revision || all;
  };

  const bool has_moved = isNews(simulation.surfaceRevision(), surface_revision_);

  // The first is kept for those who come later.
  if (is_new_ || (deformed_.getNumSubscribers() > 0 && has_moved)) {
    auto message = makeMessage<sensor_msgs::PointCloud2>(header);
    encoder_->encode(simulation.surface(true), *message);
    deformed_.publish(message);
  }
  if (simulation_points_.getNumSubscribers() > 0 && isNews(simulation.revision(), points_revision_))
    simulation_points_.publish(makeSimulationPoints(header, simulation));
  const auto now = std::chrono::steady_clock::now();
  if (markers_.getNumSubscribers() > 0 && (now >= next_full_ || isNews(simulation.revision(), markers_revision_))) {
    const bool whole = is_viewer_new_.exchange(false) || is_new_ || now >= next_full_;
    if (whole) next_full_ = now + kFullPeriod;
    auto message = boost::make_shared<visualization_msgs::MarkerArray>();
    marker_maker_->make(header, simulation, *message);
    marker_news_.reduce(whole, *message);
    if (is_new_) message->markers.insert(message->markers.begin(), makeDeleteAll(header));
    if (!message->markers.empty()) markers_.publish(message);
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

bool Publishers::hasStepListeners() const {
  const auto isHeard = [](const auto& entry) { return entry.second.getNumSubscribers() > 0; };
  return tool_wrenches_.getNumSubscribers() > 0 || std::any_of(wrenches_.begin(), wrenches_.end(), isHeard);
}

void Publishers::publishWrenches(const simulation::Simulation& simulation, std::int64_t stamp) {
  const std::vector<tool::ToolParams>& tools = simulation.tools();
  advertiseWrenches(tools);
  if (!hasStepListeners()) return;
  const std_msgs::Header header = makeHeader(stamp);
  const std::vector<simulation::ToolReaction> reactions = simulation.toolReactions();
  if (tool_wrenches_.getNumSubscribers() > 0)
    tool_wrenches_.publish(boost::make_shared<ToolWrenchArray>(makeToolWrenches(header, reactions, simulation.pinReactions())));
  for (std::size_t t = 0; t < tools.size(); ++t) {
    const auto found = wrenches_.find(tools[t].id);
    if (found == wrenches_.end() || found->second.getNumSubscribers() == 0) continue;
    const tool::Pose pose = tool::interpolate(tools[t].path, simulation.time());
    found->second.publish(boost::make_shared<geometry_msgs::WrenchStamped>(makeToolWrench(header, reactions[t], pose)));
  }
}

// A topic for each tool there is. Ids of a scene that are no names have none.
void Publishers::advertiseWrenches(const std::vector<tool::ToolParams>& tools) {
  const auto isGone = [&](const std::string& id) {
    return std::none_of(tools.begin(), tools.end(), [&](const tool::ToolParams& tool) { return tool.id == id; });
  };
  for (auto entry = wrenches_.begin(); entry != wrenches_.end();)
    entry = isGone(entry->first) ? wrenches_.erase(entry) : std::next(entry);
  for (const tool::ToolParams& tool : tools) {
    if (wrenches_.count(tool.id) > 0 || !isToolId(tool.id)) continue;
    // roscpp waits for a master that is away for as long as it is, and no step could be taken.
    if (std::chrono::steady_clock::now() < next_try_) return;
    if (!ros::master::check()) {
      next_try_ = std::chrono::steady_clock::now() + kMasterPatience;
      return;
    }
    wrenches_[tool.id] = node_.advertise<geometry_msgs::WrenchStamped>("tools/" + tool.id + "/wrench", kWrenchQueue);
  }
}

}  // namespace deformable_surface::node
