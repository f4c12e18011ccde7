#include "deformable_surface/tool/tool.h"

#include <algorithm>

namespace deformable_surface::tool {
namespace {

Pose makePose(const WaypointParams& w) {
  return {w.position, Eigen::Quaterniond(w.orientation[3], w.orientation[0], w.orientation[1], w.orientation[2]).normalized()};
}

}  // namespace

Pose interpolate(const std::vector<WaypointParams>& path, double time) {
  const auto next = std::upper_bound(path.begin(), path.end(), time, [](double t, const WaypointParams& w) { return t < w.time; });
  if (next == path.begin()) return makePose(path.front());
  if (next == path.end()) return makePose(path.back());
  const WaypointParams& last = *(next - 1);
  const Pose a = makePose(last), b = makePose(*next);
  const double share = (time - last.time) / (next->time - last.time);
  return {a.position + share * (b.position - a.position), a.orientation.slerp(share, b.orientation)};
}

}  // namespace deformable_surface::tool
