// Converts command messages to commands of the simulation, in the surface's frame. The node takes them from topics,
// `simulate` from a bag.
#pragma once

#include "deformable_surface/PointForce.h"
#include "deformable_surface/simulation/scene_params.h"

#include <geometry_msgs/WrenchStamped.h>
#include <tf2/buffer_core.h>

#include <string>

namespace deformable_surface::node {

struct SeenTransform;  // src/ros/frames.h

/// The force of a message that takes effect now (s of simulation time). A frame other than the surface's is looked up at the
/// message's stamp; seen: the transform for a message without a stamp, or null. Throws InputError for values that
/// are not finite, or negative where this is meaningless, for an empty id, and for a frame without a transform.
simulation::ForceParams toForce(const PointForce& message, double now, const std::string& surface_frame,
                                const tf2::BufferCore& transforms, const SeenTransform* seen = nullptr);

/// The same for a wrench: the force part acts at the origin of the message's frame until the timeout; the torque is not applied.
simulation::ForceParams toForce(const geometry_msgs::WrenchStamped& message, double now, const std::string& surface_frame,
                                const tf2::BufferCore& transforms, const simulation::WrenchParams& params,
                                const SeenTransform* seen = nullptr);

/// The id of the force given as a wrench.
constexpr char kWrenchId[] = "wrench";

}  // namespace deformable_surface::node
