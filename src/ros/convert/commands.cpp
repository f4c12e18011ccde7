#include "deformable_surface/ros/convert/commands.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/ros/convert/frames.h"

#include <cmath>

namespace deformable_surface::node {
namespace {

void requireFinite(const std::string& name, const Vec3& v) {
  if (!v.allFinite()) throw InputError(name + ": found a value that is not finite; accepted: finite numbers");
}

void requireNotNegative(const std::string& name, double value, const char* unit) {
  if (!(value >= 0.0 && std::isfinite(value))) {
    throw InputError(name + ": found " + formatReal(value) + "; accepted: a finite number >= 0 (" + unit + ")");
  }
}

}  // namespace

simulation::ForceParams toForce(const PointForce& message, double now, const std::string& surface_frame,
                                const tf2::BufferCore& transforms, const SeenTransform* seen) {
  const std::string name = "force " + quote(message.id);
  if (message.id.empty()) throw InputError("force id: found empty text; accepted: a name");
  const Vec3 point(message.point.x, message.point.y, message.point.z);
  const Vec3 force(message.force.x, message.force.y, message.force.z);
  requireFinite(name + " point", point);
  requireFinite(name + " force", force);
  requireNotNegative(name + " radius", message.radius, "m");
  requireNotNegative(name + " duration", message.duration, "s");

  const Eigen::Isometry3d transform =
      findTransform(name, message.header.frame_id, surface_frame, message.header.stamp, transforms, seen);
  simulation::ForceParams params;
  params.id = message.id;
  params.point = transform * point;
  params.force = transform.linear() * force;
  params.radius = message.radius;
  params.start = now;
  if (message.duration > 0.0) params.end = now + message.duration;
  return params;
}

simulation::ForceParams toForce(const geometry_msgs::WrenchStamped& message, double now, const std::string& surface_frame,
                                const tf2::BufferCore& transforms, const simulation::WrenchParams& wrench,
                                const SeenTransform* seen) {
  const Vec3 force(message.wrench.force.x, message.wrench.force.y, message.wrench.force.z);
  requireFinite("wrench force", force);
  const Eigen::Isometry3d transform =
      findTransform("wrench", message.header.frame_id, surface_frame, message.header.stamp, transforms, seen);
  simulation::ForceParams params;
  params.id = kWrenchId;
  params.point = transform.translation();
  params.force = transform.linear() * force;
  params.radius = wrench.radius;
  params.start = now;
  params.end = now + wrench.timeout;
  return params;
}

}  // namespace deformable_surface::node
