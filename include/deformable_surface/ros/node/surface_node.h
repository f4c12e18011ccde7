// The node as a class, shared by the executable and the nodelet.
#pragma once

#include "deformable_surface/simulation/scene_params.h"

#include <ros/node_handle.h>

#include <memory>

namespace deformable_surface::node {

/// The scene given by the private parameters; also checks those that only the node uses. Throws InputError with all problems.
simulation::SceneParams readNodeParameters(const ros::NodeHandle& private_node);

/// Runs in threads of its own from construction to destruction; topics and services are those of the private node handle.
class SurfaceNode {
 public:
  SurfaceNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const simulation::SceneParams& params);
  ~SurfaceNode();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deformable_surface::node
