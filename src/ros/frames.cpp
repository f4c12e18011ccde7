#include "frames.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"

#include <geometry_msgs/TransformStamped.h>
#include <tf2/exceptions.h>

namespace deformable_surface::node {

std::string withoutSlash(const std::string& frame) { return !frame.empty() && frame[0] == '/' ? frame.substr(1) : frame; }

Eigen::Isometry3d findTransform(const std::string& what, const std::string& from, const std::string& to, const ros::Time& stamp,
                                const tf2::BufferCore& transforms) {
  const std::string source = withoutSlash(from), target = withoutSlash(to);
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  if (source.empty() || source == target) return transform;
  try {
    const geometry_msgs::Transform t = transforms.lookupTransform(target, source, stamp).transform;
    transform.translate(Vec3(t.translation.x, t.translation.y, t.translation.z));
    transform.rotate(Eigen::Quaterniond(t.rotation.w, t.rotation.x, t.rotation.y, t.rotation.z).normalized());
  } catch (const tf2::TransformException& error) {
    throw InputError(what + ": there is no transform from frame " + quote(source) + " to " + quote(target) + " (" +
                     quote(error.what()) + "); accepted: frames that tf knows at the stamp");
  }
  if (!transform.matrix().allFinite()) {
    throw InputError(what + ": the transform from frame " + quote(source) + " to " + quote(target) +
                     " is not finite; accepted: a finite one");
  }
  return transform;
}

}  // namespace deformable_surface::node
