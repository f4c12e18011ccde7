// Coordinate frames and poses: one lookup in tf and one reader, with the checks that tf and the messages leave out.
#pragma once

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/types.h"
#include "deformable_surface/cloud/point_cloud.h"

#include <geometry_msgs/Pose.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <optional>
#include <string>

namespace deformable_surface::node {

/// There is no transform, which may still come.
class FrameError : public InputError {
 public:
  using InputError::InputError;
};

/// tf2 knows frames without a leading slash only; old bags have one.
std::string withoutSlash(const std::string& frame);

/// A transform as tf knew it when a command without a stamp arrived. The command uses this one in whichever step it takes effect,
/// so that a replay, which knows what tf learned later, gives the same.
struct SeenTransform {
  std::string source, target;
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
};
/// The latest transform that tf knows now; nothing if it knows none.
std::optional<SeenTransform> seeTransform(const std::string& from, const std::string& to, const tf2::BufferCore& transforms);

/// The transform that takes coordinates of `from` to those of `to`, without waiting: `seen` if that is between these frames, else
/// tf's at the stamp (0 = the latest). An empty or the same frame is no transform. Throws, beginning with `what`, FrameError if
/// there is none, and InputError if it is not finite, which tf2 lets through.
Eigen::Isometry3d findTransform(const std::string& what, const std::string& from, const std::string& to, const ros::Time& stamp,
                                const tf2::BufferCore& transforms, const SeenTransform* seen = nullptr);

/// Whether tf knows that transform at the stamp.
bool isKnown(const std::string& from, const std::string& to, const ros::Time& stamp, const tf2::BufferCore& transforms);

/// The same at the stamp, or at the latest that tf knows where that is earlier: frames of now, whose transforms are still to
/// come.
struct LatestTransform {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  ros::Time stamp;  // of the transform; 0 = it never changes
};
LatestTransform findTransformUntil(const std::string& what, const std::string& from, const std::string& to,
                                   const ros::Time& stamp, const tf2::BufferCore& transforms);

/// Moves points, normals, viewpoint and origin.
void transformCloud(const Eigen::Isometry3d& transform, cloud::PointCloud& cloud);

/// A pose of a message; an orientation left at zero counts as the identity. Throws InputError for values that are not finite and
/// orientations that are no unit quaternion.
Eigen::Isometry3d readPose(const geometry_msgs::Pose& pose);

}  // namespace deformable_surface::node
