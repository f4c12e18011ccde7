// A rigid tool in motion: where it is at a time, and what it does to a point.
#pragma once

#include "deformable_surface/geometry/solid.h"
#include "deformable_surface/tool/tool_params.h"

#include <Eigen/Geometry>

namespace deformable_surface::tool {

struct Pose {
  Vec3 position = Vec3::Zero();  // m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// Between waypoints positions run straight and orientations turn about one axis, both evenly in time; outside they rest.
Pose interpolate(const std::vector<WaypointParams>& path, double time);

/// How a tool moves: the velocity of any point that is fixed to it.
struct Motion {
  Vec3 origin = Vec3::Zero();            // m, of the tool, world
  Vec3 velocity = Vec3::Zero();          // m/s, of the tool's origin
  Vec3 angular_velocity = Vec3::Zero();  // rad/s, world

  Vec3 velocityAt(const Vec3& position) const { return velocity + angular_velocity.cross(position - origin); }
};

/// At a time on the path; on a waypoint that of the part that begins there.
Motion findMotion(const std::vector<WaypointParams>& path, double time);

/// What is wrong with a path: the sentence that reading one would give for its first problem; empty if nothing is.
std::string findProblem(const std::vector<WaypointParams>& path);

/// Whether points cannot be inside it.
inline bool isPushing(const ToolParams& tool) { return tool.mode == Mode::kSolid || tool.mode == Mode::kCut; }

/// Whether points stick to it and rub on it.
inline bool hasFriction(const ToolParams& tool) { return tool.friction > 0.0 && isPushing(tool); }

inline bool isActive(const ToolParams& tool, double time) { return tool.start <= time && time < tool.end; }

/// Distance (m, negative inside) and outward normal of a solid at a pose, in the world; beyond the limit (m) as that of the
/// solid.
inline geometry::SignedDistance findSignedDistance(const geometry::Solid& solid, const Pose& pose, const Vec3& point,
                                                   double limit = std::numeric_limits<double>::infinity()) {
  geometry::SignedDistance d = geometry::findSignedDistance(solid, pose.orientation.conjugate() * (point - pose.position), limit);
  d.normal = pose.orientation * d.normal;
  return d;
}

}  // namespace deformable_surface::tool
