// A rigid tool in motion: where it is at a time, and what it does to a point.
#pragma once

#include "deformable_surface/geometry/solid.h"
#include "deformable_surface/tool/tool_params.h"

#include <Eigen/Geometry>

namespace deformable_surface::tool {

struct Pose {
  Vec3 position = Vec3::Zero();                                    // m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// Between waypoints positions run straight and orientations turn about one axis, both evenly in time; outside they rest.
Pose interpolate(const std::vector<WaypointParams>& path, double time);

/// Distance (m, negative inside) and outward normal of a solid at a pose, in the world.
inline geometry::SignedDistance findSignedDistance(const geometry::Solid& solid, const Pose& pose, const Vec3& point) {
  geometry::SignedDistance d = geometry::findSignedDistance(solid, pose.orientation.conjugate() * (point - pose.position));
  d.normal = pose.orientation * d.normal;
  return d;
}

}  // namespace deformable_surface::tool
