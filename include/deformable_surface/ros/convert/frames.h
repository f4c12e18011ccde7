// Coordinate frames and poses: one lookup in tf and one reader, with checks that tf and the messages lack.
#pragma once

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/types.h"
#include "deformable_surface/cloud/point_cloud.h"

#include <geometry_msgs/Pose.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <chrono>
#include <optional>
#include <string>

namespace deformable_surface::node {

/// How long a command, or a step in lockstep, waits for a transform. Transforms come within a few periods of their publisher; an
/// older command has become irrelevant.
constexpr std::chrono::seconds kTransformPatience{2};

/// There is no transform yet; it may still come.
class FrameError : public InputError {
 public:
  using InputError::InputError;
};

/// tf2 knows frames without a leading slash only; old bags have one.
std::string withoutSlash(const std::string& frame);

/// The transform that tf knew when a command without a stamp arrived. The command uses it in whichever step it takes effect,
/// so that a replay, in which tf knows later transforms as well, gives the same result.
struct SeenTransform {
  std::string source, target;
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
};
/// The latest transform that tf knows now; none if it knows none.
std::optional<SeenTransform> seeTransform(const std::string& from, const std::string& to, const tf2::BufferCore& transforms);

/// The transform of coordinates in `from` to those in `to`, without waiting: `seen` if that is between these frames, else
/// tf's at the stamp (0 = the latest). An empty or the same frame means no transform. Throws, beginning with `what`, FrameError
/// if there is none, and InputError if it is not finite, which tf2 does not check.
Eigen::Isometry3d findTransform(const std::string& what, const std::string& from, const std::string& to, const ros::Time& stamp,
                                const tf2::BufferCore& transforms, const SeenTransform* seen = nullptr);

/// Whether tf knows that transform at the stamp.
bool isKnown(const std::string& from, const std::string& to, const ros::Time& stamp, const tf2::BufferCore& transforms);

/// The same at the stamp, or at the latest time that tf knows if that is earlier: for frames of now, whose transforms have
/// not come yet.
struct LatestTransform {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  ros::Time stamp;  // of the transform; 0 = it never changes
};
LatestTransform findTransformUntil(const std::string& what, const std::string& from, const std::string& to,
                                   const ros::Time& stamp, const tf2::BufferCore& transforms);

/// Moves points, normals, viewpoint and origin.
void transformCloud(const Eigen::Isometry3d& transform, cloud::PointCloud& cloud);

/// A pose of a message; an all-zero orientation counts as the identity. Throws InputError for values that are not finite and
/// for orientations that are no unit quaternion.
Eigen::Isometry3d readPose(const geometry_msgs::Pose& pose);

}  // namespace deformable_surface::node
