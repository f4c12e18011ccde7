#include "tool_arrival.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>

#include "tool_reach.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kReportedDepth = 1e-3;  // fraction of the surface's extent: a tool that appears deeper inside is reported
constexpr double kFree = 0.01;           // fraction of the initial depth that may be left at the start of the arrival
constexpr int kMostLooks = 200;          // on one path: a place that is not free by then counts as never free

constexpr Index kLook = 1024;  // points between two checks for an interrupt

// Points that a tool at a pose may push, in its frame.
class Overlap {
 public:
  /// positions: m, of the points.
  Overlap(const tool::ToolParams& tool, const tool::Pose& pose, const ContactPoints& points, const Points& positions,
          const std::vector<char>& held)
      : tool_(tool), pose_(pose), points_(points), positions_(positions), held_(held) {}

  /// m, of the deepest point with the tool moved; 0 if there is none.
  double findDepth(const Vec3& offset) const {
    double deepest = 0.0;
    forEach(offset, [&](double depth, const Vec3&) { deepest = std::max(deepest, depth); });
    return deepest;
  }

  /// Calls visit(depth, normal) for every point inside the tool moved by an offset.
  template <class Visit>
  void forEach(const Vec3& offset, Visit&& visit) const {
    const tool::Pose moved{pose_.position + offset, pose_.orientation};
    const double ball = findRadius(tool_.shape), squared_ball = ball * ball;
    for (Index i = 0; i < points_.size(); ++i) {
      endIfInterrupted(i, kLook);
      if ((positions_[i] - moved.position).squaredNorm() > squared_ball || points_.isSevered(i) || points_.isHeld(i, held_))
        continue;
      const geometry::SignedDistance d = tool::findSignedDistance(tool_.shape, moved, positions_[i], 0.0);
      if (d.distance < 0.0) visit(-d.distance, d.normal);
    }
  }

 private:
  const tool::ToolParams& tool_;
  const tool::Pose pose_;
  const ContactPoints& points_;
  const Points& positions_;
  const std::vector<char>& held_;
};

// Distance that the tool has to move in a direction until no point is deeper than some depth; the limit if it is not free before.
// A move by a point's depth is the least that can release the point, so that no free place is skipped.
double findWay(const Overlap& overlap, const Vec3& direction, double depth, double limit) {
  double way = 0.0;
  for (int look = 0; look < kMostLooks && way < limit; ++look) {
    const double now = overlap.findDepth(way * direction);
    if (now <= depth) return way;
    way += now;
  }
  return limit;
}

}  // namespace

// The nearest free place along the axes of the tool, and against the direction in which most of the overlap would be pushed.
void ContactLoad::findArrival(double time, double step, const model::State& state, const std::vector<char>& held, Body& body) {
  body.arrival = {true, Vec3::Zero(), time, time + std::max(kArrival, step)};
  if (!arrives_) return;
  const tool::Pose pose = tool::interpolate(body.tool.path, time);
  Points all;
  points_.placeAll(state.positions, all);
  const Overlap overlap(body.tool, pose, points_, all, held);
  Vec3 push = Vec3::Zero();
  double deepest = 0.0;
  Index count = 0;
  overlap.forEach(Vec3::Zero(), [&](double depth, const Vec3& normal) {
    push += depth * normal;
    deepest = std::max(deepest, depth);
    ++count;
  });
  if (count == 0) return;
  std::vector<Vec3> directions;
  if (!push.isZero(0.0)) directions.push_back(-push.normalized());
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) directions.push_back(pose.orientation * Vec3(sign * Vec3::Unit(axis)));
  double shortest = std::numeric_limits<double>::infinity();
  for (const Vec3& direction : directions) {
    const double way = findWay(overlap, direction, kFree * deepest, shortest);
    if (way < shortest) body.arrival.offset = way * direction;
    shortest = std::min(shortest, way);
  }
  body.tool.path = findArrivingPath(body.tool.path, body.arrival);
  Eigen::AlignedBox3d extent;
  for (const Vec3& x : state.positions) extent.extend(x);
  if (!(deepest > kReportedDepth * extent.diagonal().norm())) return;
  appendNotice(notice_, "tool " + quote(body.tool.id) + " appears where " + std::to_string(count) + " of " +
                            std::to_string(points_.size()) +
                            (points_.between() ? " points that may touch it are, up to " : " simulation points are, up to ") +
                            formatShort(deepest) + " m deep; " +
                            (std::isfinite(shortest) ? "it arrives from " + formatShort(shortest) + " m beside, within " +
                                                           formatShort(body.arrival.ends - time) + " s"
                                                     : "no place free of them is near, and it is there at once"));
}

void ContactLoad::adoptArrivals(const ContactLoad& other) {
  for (Body& body : bodies_)
    for (const Body& same : other.bodies_) {
      if (body.tool.id != same.tool.id || body.arrival.is_known) continue;
      body.arrival = same.arrival;
      body.tool.path = findArrivingPath(body.tool.path, body.arrival);
    }
}

std::vector<tool::WaypointParams> findArrivingPath(const std::vector<tool::WaypointParams>& path,
                                                   const ContactLoad::Arrival& arrival) {
  if (arrival.offset.isZero(0.0)) return path;
  std::vector<tool::WaypointParams> arriving;
  const auto add = [&](double time) {
    const tool::Pose pose = tool::interpolate(path, time);
    const double left = std::clamp((arrival.ends - time) / (arrival.ends - arrival.begins), 0.0, 1.0);
    const Eigen::Quaterniond& q = pose.orientation;
    arriving.push_back({time, pose.position + left * arrival.offset, Vec4(q.x(), q.y(), q.z(), q.w())});
  };
  add(arrival.begins);
  for (const tool::WaypointParams& w : path)
    if (w.time > arrival.begins && w.time < arrival.ends) add(w.time);
  add(arrival.ends);
  for (const tool::WaypointParams& w : path)
    if (w.time > arrival.ends) arriving.push_back(w);
  return arriving;
}

}  // namespace deformable_surface::simulation
