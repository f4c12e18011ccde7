#include "deformable_surface/tool/tool.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::tool {
namespace {

Pose makePose(const WaypointParams& w) {
  return {w.position, Eigen::Quaterniond(w.orientation[3], w.orientation[0], w.orientation[1], w.orientation[2]).normalized()};
}

}  // namespace

Pose interpolate(const std::vector<WaypointParams>& path, double time) {
  const auto next =
      std::upper_bound(path.begin(), path.end(), time, [](double t, const WaypointParams& w) { return t < w.time; });
  if (next == path.begin()) return makePose(path.front());
  if (next == path.end()) return makePose(path.back());
  const WaypointParams& last = *(next - 1);
  const Pose a = makePose(last), b = makePose(*next);
  const double share = (time - last.time) / (next->time - last.time);
  return {a.position + share * (b.position - a.position), a.orientation.slerp(share, b.orientation)};
}

std::string findProblem(const std::vector<WaypointParams>& path) {
  if (path.empty()) return "path: found no waypoint; accepted: at least one";
  for (std::size_t i = 0; i < path.size(); ++i) {
    const std::string place = "path[" + std::to_string(i) + "].";
    if (!std::isfinite(path[i].time)) return place + "time: found a value that is not finite; accepted: any finite number";
    if (i > 0 && !(path[i - 1].time < path[i].time))
      return place + "time: found " + formatReal(path[i].time) + " after " + formatReal(path[i - 1].time) +
             "; accepted: ascending times";
    if (!(path[i].position.array().abs() <= kMaxLength).all())
      return place + "position: found a coordinate that is not finite or too large; accepted: up to " + formatReal(kMaxLength) +
             " m";
    if (!(std::abs(path[i].orientation.norm() - 1.0) <= kLengthTolerance))
      return place + "orientation: found a quaternion of length " + formatReal(path[i].orientation.norm()) +
             "; accepted: length 1";
  }
  return "";
}

Motion findMotion(const std::vector<WaypointParams>& path, double time) {
  Motion motion;
  motion.origin = interpolate(path, time).position;
  const auto next =
      std::upper_bound(path.begin(), path.end(), time, [](double t, const WaypointParams& w) { return t < w.time; });
  if (next == path.begin() || next == path.end()) return motion;
  const Pose a = makePose(*(next - 1)), b = makePose(*next);
  const double duration = next->time - (next - 1)->time;
  motion.velocity = (b.position - a.position) / duration;
  // The shorter rotation, as in the interpolation.
  const Eigen::AngleAxisd turn(b.orientation.dot(a.orientation) < 0.0
                                   ? Eigen::Quaterniond(-(b.orientation * a.orientation.conjugate()).coeffs())
                                   : b.orientation * a.orientation.conjugate());
  motion.angular_velocity = turn.angle() / duration * turn.axis();
  return motion;
}

}  // namespace deformable_surface::tool
