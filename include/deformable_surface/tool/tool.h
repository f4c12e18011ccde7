// A rigid tool in motion: its pose at a time, and its effect on a point.
#pragma once

#include "deformable_surface/geometry/solid.h"
#include "deformable_surface/tool/tool_params.h"

#include <Eigen/Geometry>

namespace deformable_surface::tool {

struct Pose {
  Vec3 position = Vec3::Zero();  // m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// Linear interpolation of positions and spherical of orientations between waypoints; constant outside of the path.
Pose interpolate(const std::vector<WaypointParams>& path, double time);

/// Calls visit(time) at each corner of the path strictly between two times.
template <class Visit>
void forEachCorner(const std::vector<WaypointParams>& path, double begin, double end, const Visit& visit) {
  for (const WaypointParams& w : path)
    if (w.time > begin && w.time < end) visit(w.time);
}

/// Motion of a rigid tool: gives the velocity of any point fixed to it.
struct Motion {
  Vec3 origin = Vec3::Zero();            // m, of the tool, world
  Vec3 velocity = Vec3::Zero();          // m/s, of the tool's origin
  Vec3 angular_velocity = Vec3::Zero();  // rad/s, world

  Vec3 velocityAt(const Vec3& position) const { return velocity + angular_velocity.cross(position - origin); }
};

/// Motion at a time on the path; on a waypoint that of the segment that begins there.
Motion findMotion(const std::vector<WaypointParams>& path, double time);

/// The first problem of a path, in the same sentence as when it is read; empty if there is none.
std::string findProblem(const std::vector<WaypointParams>& path);

/// Whether the tool keeps points out.
inline bool isPushing(const ToolParams& tool) { return tool.mode == Mode::kSolid || tool.mode == Mode::kCut; }

/// Whether the tool has friction on points.
inline bool hasFriction(const ToolParams& tool) { return tool.friction > 0.0 && isPushing(tool); }

inline bool isActive(const ToolParams& tool, double time) { return tool.start <= time && time < tool.end; }

/// Distance (m, negative inside) and outward normal of a solid at a pose, in the world. Beyond the limit (m), as in
/// geometry::findSignedDistance().
inline geometry::SignedDistance findSignedDistance(const geometry::Solid& solid, const Pose& pose, const Vec3& point,
                                                   double limit = std::numeric_limits<double>::infinity()) {
  geometry::SignedDistance d = geometry::findSignedDistance(solid, pose.orientation.conjugate() * (point - pose.position), limit);
  d.normal = pose.orientation * d.normal;
  return d;
}

}  // namespace deformable_surface::tool
