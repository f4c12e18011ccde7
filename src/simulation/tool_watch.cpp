#include "tool_watch.h"

#include <algorithm>

#include "tool_reach.h"

namespace deformable_surface::simulation {
namespace {

using tool::Pose;
using tool::ToolParams;

void extend(Eigen::AlignedBox3d& box, const ToolParams& tool, const Pose& pose) {
  const Vec3 reach = Vec3::Constant(findRadius(tool.shape) + tool.reach);
  box.extend(Vec3(pose.position - reach));
  box.extend(Vec3(pose.position + reach));
}

// Adds the tool's pose at the beginning of the step and at the corners of its path: a jump is covered from end to end.
void extendByWay(Eigen::AlignedBox3d& box, const ToolParams& tool, double time, double step) {
  extend(box, tool, tool::interpolate(tool.path, time - step));
  for (const tool::WaypointParams& w : tool.path)
    if (w.time > time - step && w.time < time) extend(box, tool, tool::interpolate(tool.path, w.time));
}

bool isSame(const Pose& a, const Pose& b) { return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs(); }

// Whether the tool leaves its final pose within the step, as one that moves away and returns.
bool turnsWithin(const ToolParams& tool, double time, double step) {
  const Pose end = tool::interpolate(tool.path, time);
  return std::any_of(tool.path.begin(), tool.path.end(), [&](const tool::WaypointParams& w) {
    return w.time > time - step && w.time < time && !isSame(tool::interpolate(tool.path, w.time), end);
  });
}

// Compares all but the path and the times at which the tool acts.
bool isSame(const ToolParams& a, const ToolParams& b) {
  return a.id == b.id && a.mode == b.mode && geometry::isSame(a.shape, b.shape) && a.friction == b.friction &&
         a.kinetic_friction.valueOr(a.friction) == b.kinetic_friction.valueOr(b.friction) && a.strength == b.strength &&
         a.reach == b.reach;
}

}  // namespace

const std::vector<Eigen::AlignedBox3d>& ToolWatch::look(const std::vector<ToolParams>& tools, double time, double step) {
  changed_.clear();
  for (std::size_t t = 0; t < std::max(tools.size(), seen_.size()); ++t) {
    Eigen::AlignedBox3d box;
    if (t >= tools.size()) {  // gone
      if (seen_[t].is_active) extend(box, seen_[t].tool, seen_[t].pose);
    } else {
      const ToolParams& tool = tools[t];
      const bool is_active = tool::isActive(tool, time);
      const Pose pose = tool::interpolate(tool.path, time);
      const bool is_known = t < seen_.size() && isSame(tool, seen_[t].tool);
      const bool rests = isSame(pose, is_known ? seen_[t].pose : pose) && !turnsWithin(tool, time, step);
      if (is_known && is_active == seen_[t].is_active && (!is_active || rests)) continue;
      if (is_active) extend(box, tool, pose);
      if (t < seen_.size() && seen_[t].is_active) extend(box, seen_[t].tool, seen_[t].pose);
      if (is_active) extendByWay(box, tool, time, step);
      if (!is_known) {
        if (t >= seen_.size()) seen_.emplace_back();
        seen_[t].tool = tool;
        seen_[t].tool.path.clear();
      }
      seen_[t].is_active = is_active;
      seen_[t].pose = pose;
    }
    if (!box.isEmpty()) changed_.push_back(box);
  }
  seen_.resize(tools.size());
  return changed_;
}

}  // namespace deformable_surface::simulation
