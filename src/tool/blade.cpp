#include "deformable_surface/tool/blade.h"

#include "deformable_surface/tool/crossing.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::tool {
namespace {

using geometry::SignedDistance;

constexpr double kOut = 1e-6;       // of the way: how far outside a point that was inside begins
constexpr int kMaxLooks = 10000;    // in a step: what moves so fast beside its resolution is no cut that anybody meant

Vec3 toTool(const Pose& pose, const Vec3& point) { return pose.orientation.conjugate() * (point - pose.position); }

Vec3 pushOut(const geometry::Solid& solid, const Vec3& point, double margin) {
  const SignedDistance d = geometry::findSignedDistance(solid, point, 0.0);
  return d.distance > 0.0 ? point : Vec3(point + (margin - d.distance) * d.normal);
}

}  // namespace

bool isBetween(const geometry::Solid& solid, const Vec3& a, const Vec3& b) {
  const double margin = kOut * (b - a).norm();
  const Vec3 from = pushOut(solid, a, margin), to = pushOut(solid, b, margin);
  const std::optional<Entry> in = findEntry(solid, from, to);
  if (!in) return false;
  const std::optional<Entry> out = findEntry(solid, to, from);
  return out && in->normal.dot(out->normal) < 0.0;
}

BladeSweep::BladeSweep(const ToolParams& tool, double time, double step, const Points& before, const Points& after, double reach,
                       double resolution)
    : solid_(tool.shape), reach_(reach) {
  const Pose first = interpolate(tool.path, time), last = interpolate(tool.path, time + step);
  // A path with corners, or one that turns, is longer than the way from its beginning to its end.
  double longer = 1.0;
  for (const WaypointParams& w : tool.path)
    if (w.time > time && w.time < time + step) longer += 1.0;
  bool is_near = false;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Vec3 from = toTool(first, before[i]), to = toTool(last, after[i]);
    const double travel = (to - from).norm();
    if (!(geometry::findSignedDistance(solid_, from, reach + travel).distance <= reach + travel)) continue;
    is_near = true;
    travel_ = std::max(travel_, travel);
  }
  if (!is_near) return;
  travel_ *= longer;
  const int looks = std::min(kMaxLooks, 1 + static_cast<int>(travel_ / resolution));
  for (int k = 0; k <= looks; ++k) poses_.push_back(interpolate(tool.path, time + k * step / looks));
}

bool BladeSweep::isNear(const Vec3& point) const {
  const double reach = reach_ + travel_;
  return isNear() && geometry::findSignedDistance(solid_, toTool(poses_.front(), point), reach).distance <= reach;
}

bool BladeSweep::wentBetween(const Vec3& a_before, const Vec3& a_after, const Vec3& b_before, const Vec3& b_after) const {
  if (!isNear()) return false;
  const Vec3 middle = 0.5 * (a_before + b_before);
  const double reach = 0.5 * (b_before - a_before).norm() + travel_;
  if (!(geometry::findSignedDistance(solid_, toTool(poses_.front(), middle), reach).distance <= reach)) return false;
  for (std::size_t k = 0; k < poses_.size(); ++k) {
    const double share = static_cast<double>(k) / (poses_.size() - 1);
    if (isBetween(solid_, toTool(poses_[k], a_before + share * (a_after - a_before)),
                  toTool(poses_[k], b_before + share * (b_after - b_before))))
      return true;
  }
  return false;
}

}  // namespace deformable_surface::tool
