#include "deformable_surface/ros/convert/frames.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"

#include <geometry_msgs/TransformStamped.h>
#include <tf2/exceptions.h>

#include <cmath>

namespace deformable_surface::node {
namespace {

// A unit quaternion in float32 is off by less; a larger error means that no rotation was intended.
constexpr double kUnitTolerance = 1e-3;
constexpr std::size_t kMostOfTf = 300;  // characters of its reason: all of it, unless names of frames are long

// tf interpolates where it knows a later transform than that of the stamp, and then the last bits are others. Replays, which get
// transforms earlier or later than clouds, shall have the same.
double withoutLastBits(double value) {
  constexpr double kSteps = 1 << 30;  // of a metre, or of one: a nanometre, a nanoradian
  return std::round(kSteps * value) / kSteps + 0.0;
}

LatestTransform lookUp(const std::string& what, const std::string& source, const std::string& target, const ros::Time& stamp,
                       const tf2::BufferCore& transforms) {
  LatestTransform found;
  try {
    const geometry_msgs::TransformStamped stamped = transforms.lookupTransform(target, source, stamp);
    const geometry_msgs::Transform& t = stamped.transform;
    found.stamp = stamped.header.stamp;
    const auto round = withoutLastBits;
    found.transform.translate(Vec3(round(t.translation.x), round(t.translation.y), round(t.translation.z)));
    found.transform.rotate(
        Eigen::Quaterniond(round(t.rotation.w), round(t.rotation.x), round(t.rotation.y), round(t.rotation.z)).normalized());
  } catch (const tf2::TransformException& error) {
    throw FrameError(what + ": there is no transform from frame " + quote(source) + " to " + quote(target) + " (" +
                     toPrintable(std::string(error.what()).substr(0, kMostOfTf)) +
                     "); accepted: frames that tf knows at the stamp");
  }
  if (!found.transform.matrix().allFinite()) {
    throw InputError(what + ": the transform from frame " + quote(source) + " to " + quote(target) +
                     " is not finite; accepted: a finite one");
  }
  return found;
}

}  // namespace

std::string withoutSlash(const std::string& frame) { return !frame.empty() && frame[0] == '/' ? frame.substr(1) : frame; }

std::optional<SeenTransform> seeTransform(const std::string& from, const std::string& to, const tf2::BufferCore& transforms) {
  const std::string source = withoutSlash(from), target = withoutSlash(to);
  if (source.empty() || target.empty() || source == target) return std::nullopt;
  try {
    return SeenTransform{source, target, lookUp("", source, target, ros::Time(), transforms).transform};
  } catch (const InputError&) {
    return std::nullopt;  // the step that carries the command out says why
  }
}

Eigen::Isometry3d findTransform(const std::string& what, const std::string& from, const std::string& to, const ros::Time& stamp,
                                const tf2::BufferCore& transforms, const SeenTransform* seen) {
  const std::string source = withoutSlash(from), target = withoutSlash(to);
  if (source.empty() || source == target) return Eigen::Isometry3d::Identity();
  if (seen && seen->source == source && seen->target == target) return seen->transform;
  return lookUp(what, source, target, stamp, transforms).transform;
}

bool isKnown(const std::string& from, const std::string& to, const ros::Time& stamp, const tf2::BufferCore& transforms) {
  const std::string source = withoutSlash(from), target = withoutSlash(to);
  return source.empty() || source == target || transforms.canTransform(target, source, stamp);
}

LatestTransform findTransformUntil(const std::string& what, const std::string& from, const std::string& to,
                                   const ros::Time& stamp, const tf2::BufferCore& transforms) {
  const std::string source = withoutSlash(from), target = withoutSlash(to);
  if (source.empty() || source == target) return {};
  const LatestTransform latest = lookUp(what, source, target, ros::Time(), transforms);
  if (latest.stamp <= stamp || stamp.isZero()) return latest;
  return lookUp(what, source, target, stamp, transforms);
}

void transformCloud(const Eigen::Isometry3d& transform, cloud::PointCloud& cloud) {
  if (transform.isApprox(Eigen::Isometry3d::Identity(), 0.0)) return;
  for (Vec3& p : cloud.positions) p = transform * p;
  for (Vec3& n : cloud.normals) n = transform.linear() * n;
  if (cloud.viewpoint) cloud.viewpoint = transform * *cloud.viewpoint;
  cloud.origin = transform * cloud.origin;
}

Eigen::Isometry3d readPose(const geometry_msgs::Pose& pose) {
  const Vec3 position(pose.position.x, pose.position.y, pose.position.z);
  const auto& o = pose.orientation;
  Eigen::Quaterniond orientation(o.w, o.x, o.y, o.z);
  if (orientation.coeffs().isZero(0.0)) orientation.setIdentity();
  const bool is_finite = position.allFinite();
  if (!is_finite || !(std::abs(orientation.norm() - 1.0) <= kUnitTolerance)) {
    throw InputError(
        "pose: found " +
        (is_finite ? "an orientation of length " + formatReal(orientation.norm()) : "a position that is not finite") +
        "; accepted: finite numbers and a unit quaternion");
  }
  return Eigen::Translation3d(position) * orientation.normalized();
}

}  // namespace deformable_surface::node
