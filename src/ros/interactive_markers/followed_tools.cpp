// Tools that follow their markers at a limited speed, and the warm hand: a tool that moves what it holds, with a warm zone behind
// it. Apart from the menus, because the time of the surface drives them.
#include "marker_server.h"

#include "deformable_surface/ros/convert/tool_commands.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::node {
namespace {

using shape_msgs::SolidPrimitive;

// In spacings. Those of scenes/particles_handle.yaml, but for the height, which is that of its second hand: what is held below
// the tip of a stem does not tear at a sharp edge, and on a bare sheet the height makes no difference.
constexpr double kHandRadius = 4.5, kHandHeight = 5.6;
// How far the warm zone reaches beside the hand, behind its end, and from its middle ahead.
constexpr double kWarmBeside = 3.0, kWarmBehind = 3.75, kWarmAhead = 0.9;
constexpr double kHandSpeed = 6.0;  // spacings per second

}  // namespace

/// m/s; infinite: the tool follows at once.
double MarkerServer::limitOf(const HeldTool& held) const {
  return params_.speed.valueOr(held.is_warm_hand ? kHandSpeed * held.spacing : std::numeric_limits<double>::infinity());
}

void MarkerServer::makeWay(HeldTool& held) {
  if (std::isfinite(limitOf(held))) held.way.emplace(toPose(held.tool.pose), 0.5 * findExtent(held.tool.primitive), held.spacing);
}

void MarkerServer::takeStatistics(const Statistics& message) {
  const bool is_anew = time_ && (message.cloud != cloud_ || message.simulation_time < *time_);
  // The surface takes no longer to go to a new pose: what was not heard of must not become a jerk.
  const double elapsed = time_ && !is_anew ? std::min(message.simulation_time - *time_, ToolCommands::kLongestMove) : 0.0;
  if (is_anew || message.header.stamp < began_stamp_) began_stamp_ = message.header.stamp;
  time_ = message.simulation_time;
  cloud_ = message.cloud;
  for (auto& [id, held] : held_) {
    if (is_anew && held.is_warm_hand && held.acts) {
      release(held);
      showAnswer("the surface began anew: " + id + " has let go", false);
    } else {
      follow(held, elapsed);
    }
  }
}

void MarkerServer::follow(HeldTool& held, double elapsed) {
  if (!held.acts || !held.way || !(elapsed > 0.0)) return;
  if (!held.way->hasArrived()) {
    held.way->advance(limitOf(held) * elapsed);
    held.is_warm = held.is_warm_hand;
    sendHeld(held);
  } else if (held.is_warm) {
    held.is_warm = false;
    drop(warmthOf(held.tool.id));
    showAnswer(held.tool.id + " is at its marker", true);
  }
}

/// At the place where it is, which may be behind its marker. begins_anew: it lets go of what it holds first, in the same step.
void MarkerServer::sendHeld(HeldTool& held, bool begins_anew) {
  MarkedTool tool = held.tool;
  tool.pose = held.pose();
  unwanted_.erase(tool.id);
  if (held.is_warm) unwanted_.erase(warmthOf(tool.id));
  ToolArray array;
  if (begins_anew) array.tools.push_back(makeMessage(tool, Tool::DELETE));
  array.tools.push_back(makeMessage(tool, Tool::ADD));
  if (held.is_warm) array.tools.push_back(makeMessage(makeWarmth(held), Tool::ADD));
  tools_.publish(array);
  held.sent = ros::WallTime::now();
}

/// Its axis is normal to the surface. It holds nothing yet.
void MarkerServer::addWarmHand() {
  const std::size_t spot = findSpot();
  MarkedTool tool;
  tool.id = makeId();
  tool.mode = Tool::MOVE;
  tool.primitive = makePrimitive(SolidPrimitive::CYLINDER, {kHandHeight * spacing_, kHandRadius * spacing_});
  tool.pose = makePose(tool::Pose{points_[spot], Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), normalAt(spot))});
  HeldTool& held = held_[tool.id];
  held.tool = tool;
  held.spacing = spacing_;
  held.is_warm_hand = true;
  held.acts = false;
  for (const std::string& id : {tool.id, warmthOf(tool.id)}) unwanted_.emplace(id, ros::WallTime());
  showTool(held);
}

/// Of what is inside now; it lets go of the rest.
void MarkerServer::takeHold(HeldTool& hand) {
  const bool holds = std::exchange(hand.acts, true);
  if (!holds) makeWay(hand);
  hand.held_since = ros::WallTime::now();
  hand.num_told.reset();
  hand.repeats = 0;
  sendHeld(hand, holds);
}

void MarkerServer::letGo(HeldTool& hand) {
  if (!hand.acts) return;
  const bool was_warm = hand.is_warm;
  release(hand);
  drop(hand.tool.id);
  if (was_warm) drop(warmthOf(hand.tool.id));
}

/// Its marker returns to the place where it was.
void MarkerServer::release(HeldTool& hand) {
  hand.tool.pose = hand.pose();
  hand.way.reset();
  hand.acts = hand.is_warm = false;
  server_.setPose(hand.tool.id, hand.tool.pose);
  for (const std::string& id : {hand.tool.id, warmthOf(hand.tool.id)}) unwanted_.emplace(id, ros::WallTime());
}

/// Deletes a tool of a warm hand.
void MarkerServer::drop(const std::string& id) {
  MarkedTool tool;
  tool.id = id;
  send(tool, Tool::DELETE);
  there_.erase(id);
  unwanted_[id] = ros::WallTime::now();
}

void MarkerServer::dropUnwanted() {
  if (there_stamp_ < began_stamp_) return;
  for (const auto& [id, deleted] : unwanted_)
    if (there_.count(id) > 0 && (ros::WallTime::now() - deleted).toSec() > kRepeatPeriod) drop(id);
}

MarkedTool MarkerServer::makeWarmth(const HeldTool& hand) const {
  const auto& sizes = hand.tool.primitive.dimensions;
  const double behind = 0.5 * sizes[SolidPrimitive::CYLINDER_HEIGHT] + kWarmBehind * hand.spacing;
  const double ahead = kWarmAhead * hand.spacing;
  MarkedTool warmth;
  warmth.id = warmthOf(hand.tool.id);
  warmth.mode = Tool::HEAT;
  warmth.primitive = makePrimitive(SolidPrimitive::CYLINDER,
                                   {behind + ahead, sizes[SolidPrimitive::CYLINDER_RADIUS] + kWarmBeside * hand.spacing});
  tool::Pose pose = toPose(hand.pose());
  pose.position += pose.orientation * Vec3(0.0, 0.0, 0.5 * (ahead - behind));
  warmth.pose = makePose(pose);
  return warmth;
}

}  // namespace deformable_surface::node
