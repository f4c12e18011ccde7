#include "marker_server.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/median.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <sensor_msgs/point_cloud2_iterator.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::node {
namespace {

using shape_msgs::SolidPrimitive;
using visualization_msgs::InteractiveMarkerFeedback;

// RViz reports four times a second that it is still there; without a report the user or the network is gone.
constexpr double kGripPatience = 2.0;  // s
// A tool that the surface lost (a reset, another cloud) is sent again. One that it refuses is sent again only for a while.
constexpr int kMaxRepeats = 3;
// If the number of points grows or falls by this factor, it is another surface.
constexpr double kNewShare = 1.2;
// Handles follow points that have moved by this share of the spacing; less is invisible.
constexpr double kSeenShare = 0.05;
// Of the surface's extent.
constexpr double kPanelShare = 0.04;
// Overlapping balls, so that every visible place of the surface can be clicked, and a spot that is larger than
// them.
constexpr double kBallShare = 2.0, kSpotShare = 2.2;

Vec3 toVec3(const geometry_msgs::Point& p) { return {p.x, p.y, p.z}; }

bool hasField(const sensor_msgs::PointCloud2& message, const std::string& name) {
  return std::any_of(message.fields.begin(), message.fields.end(), [&](const auto& field) { return field.name == name; });
}

Points readVectors(const sensor_msgs::PointCloud2& message, const char* first) {
  Points vectors;
  vectors.reserve(message.width);
  for (sensor_msgs::PointCloud2ConstIterator<float> at(message, first); at != at.end(); ++at)
    vectors.emplace_back(at[0], at[1], at[2]);
  return vectors;
}

}  // namespace

MarkerServer::MarkerServer(const MarkerParams& params)
    : params_(params),
      surface_(ros::names::resolve(params.surface)),
      node_(surface_),
      tools_(node_.advertise<ToolArray>("tools", 10)),
      points_subscriber_(node_.subscribe<sensor_msgs::PointCloud2>(
          "simulation_points", 1, [this](const sensor_msgs::PointCloud2ConstPtr& m) { takePoints(*m); })),
      wrenches_subscriber_(
          node_.subscribe<ToolWrenchArray>("tool_wrenches", 1, [this](const ToolWrenchArrayConstPtr& m) { takeWrenches(*m); })),
      statistics_subscriber_(
          node_.subscribe<Statistics>("statistics", 10, [this](const StatisticsConstPtr& m) { takeStatistics(*m); })),
      timer_(node_.createWallTimer(ros::WallDuration(1.0 / params.rate), [this](const ros::WallTimerEvent&) { refresh(); })),
      server_(ros::this_node::getName()) {
  ROS_INFO_STREAM("waiting for the points of " << surface_);
}

// ---- From the surface ----

void MarkerServer::takePoints(const sensor_msgs::PointCloud2& message) {
  if (message.width == 0) return;
  // Particles may be added and removed in every frame.
  const double growth = static_cast<double>(message.width) / static_cast<double>(std::max<std::size_t>(num_measured_, 1));
  const bool is_new = header_.frame_id != message.header.frame_id || growth > kNewShare || growth < 1.0 / kNewShare;
  header_.frame_id = message.header.frame_id;
  points_ = readVectors(message, "x");
  normals_ = readVectors(message, "normal_x");
  ids_.clear();
  if (hasField(message, "id"))
    for (sensor_msgs::PointCloud2ConstIterator<std::uint32_t> id(message, "id"); id != id.end(); ++id) ids_.push_back(*id);
  if (is_new) measure();
}

/// Sizes of handles and tools follow those of the surface.
void MarkerServer::measure() {
  num_measured_ = points_.size();
  const Box box = findMainBox(points_);
  extent_ = box.extent();
  text_place_ = placeText(box, header_.frame_id);
  const cloud::KdTree tree(points_);
  std::vector<cloud::Neighbor> nearest;
  std::vector<double> distances;
  for (const Vec3& p : points_) {
    tree.nearest(p, 2, nearest);
    distances.push_back(std::sqrt(nearest.back().squared_distance));
  }
  const double median = findMedian(std::move(distances));
  spacing_ = median > 0.0 ? median : extent_;
  if (!has_menus_) {
    makeMenus();
    chooseSpot(text_place_.anchor);  // where it is seen
  }
  shown_.clear();
  showPanel();
}

void MarkerServer::takeWrenches(const ToolWrenchArray& message) {
  const ros::WallTime now = ros::WallTime::now();
  noticeSlip(message);
  there_.clear();
  for (const ToolWrench& wrench : message.wrenches) there_.insert(wrench.id);
  there_stamp_ = message.header.stamp;
  std::string refused;
  const auto find = [&](const std::string& id) {
    const auto found =
        std::find_if(message.wrenches.begin(), message.wrenches.end(), [&](const ToolWrench& wrench) { return wrench.id == id; });
    return found == message.wrenches.end() ? nullptr : &*found;
  };
  for (auto& [id, held] : held_) {
    if (!held.acts) continue;
    if (const ToolWrench* const wrench = find(id)) {
      held.repeats = 0;
      // The first message can still be of what was held before.
      const bool is_news =
          !held.num_told || ((now - held.held_since).toSec() < kRepeatPeriod && *held.num_told != wrench->contacts);
      if (held.is_warm_hand && is_news) {
        held.num_told = wrench->contacts;
        showAnswer(id + " holds " + std::to_string(wrench->contacts) + " particles", wrench->contacts > 0);
      }
    } else if ((now - held.sent).toSec() > kRepeatPeriod) {
      if (++held.repeats > kMaxRepeats) refused = id;
      sendHeld(held);
    }
  }
  if (refused.empty()) return;
  removeTool(held_.at(refused));
  showAnswer("the surface does not take " + refused + "; its log says why", false);
}

/// A grip that released its points does not take hold again; a handle that moves alone would not show why.
void MarkerServer::noticeSlip(const ToolWrenchArray& message) {
  if (!grip_) return;
  const auto is_grip = [](const ToolWrench& wrench) { return wrench.id == kGripId; };
  const auto found = std::find_if(message.wrenches.begin(), message.wrenches.end(), is_grip);
  if (found == message.wrenches.end()) return;
  const bool has_slipped = grip_->holds && found->contacts == 0;
  grip_->holds = found->contacts > 0;
  if (!has_slipped) return;
  endGrip();
  showAnswer("the surface slipped off: a pull is limited to at most " + formatShort(params_.strength) + " N", false);
}

/// At the rate of the parameters, and only what has changed. Only this applies changes: a menu must not vanish in its call.
void MarkerServer::refresh() {
  // Without a subscriber nothing is shown.
  if (points_.empty() || tools_.getNumSubscribers() == 0) return;
  dropUnwanted();
  followSurface();
  server_.applyChanges();
}

void MarkerServer::followSurface() {
  if (grip_) {
    if ((ros::WallTime::now() - grip_->heard).toSec() > kGripPatience) {
      endGrip();
      showAnswer("nothing was heard of the pull for a while; let go", false);
    }
    return;  // RViz moves a dragged marker itself
  }
  const std::size_t spot = findSpot();
  bool has_moved = shown_.size() != points_.size();
  for (std::size_t i = 0; i < points_.size() && !has_moved; ++i)
    has_moved = !((points_[i] - shown_[i]).norm() <= kSeenShare * spacing_);
  if (!has_moved) return;
  const bool is_first = shown_.size() != points_.size();
  shown_ = points_;
  const auto pull = [this](const Feedback& feedback) { onPull(feedback); };
  server_.insert(makeSurfaceHandle(header_, points_, kBallShare * spacing_), pull);
  // An open menu would close if its marker were sent again.
  if (is_first) {
    server_.insert(makeSpotHandle(header_, points_[spot], kSpotShare * spacing_), pull);
    spot_menu_.apply(server_, kSpotHandle);
  } else {
    server_.setPose(kSpotHandle, makePose(points_[spot]));
  }
}

// ---- From the user ----

void MarkerServer::onPull(const Feedback& feedback) {
  const Vec3 handle = toVec3(feedback->pose.position);
  if (!handle.allFinite()) return;
  switch (feedback->event_type) {
    case InteractiveMarkerFeedback::MOUSE_DOWN: {
      endGrip();
      const bool is_spot = feedback->marker_name == kSpotHandle;
      // Without a depth under the mouse the intended point is unknown.
      if (!is_spot && !feedback->mouse_point_valid) return;
      if (!is_spot) chooseSpot(toVec3(feedback->mouse_point));
      grip_ = Grip{feedback->marker_name, points_[findSpot()], handle, false, ros::WallTime::now(), false};
      return;
    }
    case InteractiveMarkerFeedback::POSE_UPDATE:
    case InteractiveMarkerFeedback::KEEP_ALIVE:
      if (grip_ && grip_->handle == feedback->marker_name) moveGrip(handle);
      return;
    case InteractiveMarkerFeedback::MOUSE_UP:
      if (grip_ && grip_->handle == feedback->marker_name) endGrip();
      return;
  }
}

void MarkerServer::moveGrip(const Vec3& handle) {
  grip_->heard = ros::WallTime::now();
  const Vec3 way = handle - grip_->start;
  if (!grip_->is_sent && way.isZero()) return;
  MarkedTool tool;
  tool.id = kGripId;
  tool.mode = Tool::MOVE;
  tool.primitive = makePrimitive(SolidPrimitive::SPHERE, {radius()});
  tool.strength = params_.strength;
  // The tool takes hold where the surface is, and then moves.
  if (!grip_->is_sent) {
    tool.pose = makePose(points_[findSpot()]);
    send(tool, Tool::ADD);
  }
  grip_->is_sent = true;
  tool.pose = makePose(grip_->from + way);
  send(tool, Tool::ADD);
}

void MarkerServer::endGrip() {
  if (!grip_) return;
  MarkedTool tool;
  tool.id = kGripId;
  if (grip_->is_sent) send(tool, Tool::DELETE);
  grip_.reset();
  // The handles return to the surface with the next refresh.
  shown_.assign(points_.size(), Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
}

void MarkerServer::chooseSpot(const Vec3& point) {
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < points_.size(); ++i)
    if ((points_[i] - point).squaredNorm() < (points_[nearest] - point).squaredNorm()) nearest = i;
  spot_ = isOfParticles() ? ids_[nearest] : static_cast<std::uint32_t>(nearest);
}

/// The row of the spot; the first if its particle is gone.
std::size_t MarkerServer::findSpot() const {
  if (!isOfParticles()) return spot_ < points_.size() ? spot_ : 0;
  const auto found = std::find(ids_.begin(), ids_.end(), spot_);
  return found == ids_.end() ? 0 : static_cast<std::size_t>(found - ids_.begin());
}

/// A point without neighbours has no normal; up is as good as any other direction then.
Vec3 MarkerServer::normalAt(std::size_t row) const { return normals_[row].allFinite() ? normals_[row] : Vec3(Vec3::UnitZ()); }

void MarkerServer::onTool(const Feedback& feedback) {
  const auto found = held_.find(feedback->marker_name);
  if (found == held_.end() || feedback->event_type != InteractiveMarkerFeedback::POSE_UPDATE) return;
  HeldTool& held = found->second;
  try {
    const tool::Pose pose = toPose(feedback->pose);
    if (held.way) held.way->append(pose);
  } catch (const InputError& error) {
    return showAnswer(toOneLine(error.what()), false);
  }
  held.tool.pose = feedback->pose;
  if (held.acts && !held.way) sendHeld(held);
}

// ---- Showing and sending ----

void MarkerServer::showTool(HeldTool& held) {
  server_.insert(makeToolHandle(header_, held.tool), [this](const Feedback& feedback) { onTool(feedback); });
  (held.is_warm_hand ? hand_menu_ : tool_menu_).apply(server_, held.tool.id);
  held.repeats = 0;
  if (held.acts) sendHeld(held);
}

void MarkerServer::showPanel() {
  server_.insert(makePanelHandle(header_, text_place_, kPanelShare * extent_, sentence_));
  panel_menu_.apply(server_, kPanelHandle);
}

/// Numbered, so that the status of a tool tells of which command it is.
Tool MarkerServer::makeMessage(const MarkedTool& tool, std::uint8_t action) {
  Tool message;
  message.header.seq = ++num_commands_;
  message.header.frame_id = header_.frame_id;
  message.id = tool.id;
  message.action = action;
  message.mode = tool.mode;
  message.primitive = tool.primitive;
  message.pose = tool.pose;
  message.strength = tool.strength;
  if (tool.mode == Tool::HEAT) message.strength = params_.heat;
  if (tool.mode == Tool::ATTRACT) message.strength = params_.attraction;
  return message;
}

void MarkerServer::send(const MarkedTool& tool, std::uint8_t action) {
  ToolArray array;
  array.tools.push_back(makeMessage(tool, action));
  tools_.publish(array);
}

void MarkerServer::showAnswer(const std::string& sentence, bool is_good) {
  if (is_good) {
    ROS_INFO_STREAM(sentence);
  } else {
    ROS_WARN_STREAM(sentence);
  }
  sentence_ = sentence;
  showPanel();
}

}  // namespace deformable_surface::node
