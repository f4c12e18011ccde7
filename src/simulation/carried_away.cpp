#include "carried_away.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "tool_reach.h"

namespace deformable_surface::simulation {
namespace {

// Of the size of the scene. A block of 500 points and a sheet of 400 on a plane that is tilted by 0.001 to 80 degrees moved by 15
// to 8e5 of it in a step; a ball in a groove and in pits of planes, and sheets and blocks that fell on planes, by 1 at most.
constexpr double kFar = 10.0;

}  // namespace

double findCarriedAway(const solve::System& system, const ContactLoad& contact, double time, const std::vector<double>& stiffness,
                       const Points& before, const Points& after) {
  Eigen::AlignedBox3d box;
  for (const Vec3& x : before) box.extend(x);
  double size = box.diagonal().norm();
  const auto moved = [&](std::size_t i) { return (after[i] - before[i]).norm(); };
  const auto isFar = [&](std::size_t i) { return moved(i) > kFar * size; };
  bool is_any_far = false;
  for (std::size_t i = 0; i < before.size() && !is_any_far; ++i) is_any_far = isFar(i);
  if (!is_any_far) return 0.0;
  const Vec3 middle = box.center();
  double way = 0.0, largest_tool = 0.0;
  for (const ContactLoad::Body& body : contact.all()) {
    const tool::ToolParams& tool = body.tool;
    const tool::Pose pose = tool::interpolate(tool.path, time);
    if (tool.shape.kind == geometry::Solid::Kind::kPlane) {
      way = std::max(way, std::abs(tool::findSignedDistance(tool.shape, pose, middle, 0.0).distance));
    } else {
      way = std::max(way, (middle - pose.position).norm());
      largest_tool = std::max(largest_tool, 2.0 * findRadius(tool.shape));
    }
  }
  size += way + largest_tool;
  std::vector<Index> part;
  system.labelParts(part);
  std::vector<char> is_held(part.size(), 0);
  for (std::size_t i = 0; i < part.size(); ++i)
    if (system.isHeld(static_cast<Index>(i)) || stiffness[i] > 0.0) is_held[part[i]] = 1;
  double farthest = 0.0;
  for (std::size_t i = 0; i < part.size(); ++i)
    if (!is_held[part[i]] && isFar(i)) farthest = std::max(farthest, moved(i));
  return farthest;
}

}  // namespace deformable_surface::simulation
