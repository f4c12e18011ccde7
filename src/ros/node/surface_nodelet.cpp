// The node as a nodelet, in a library of its own: pluginlib loads it by name, and nothing else links nodelets.
#include "deformable_surface/base/error.h"
#include "deformable_surface/ros/node/surface_node.h"

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include <exception>
#include <memory>

namespace deformable_surface::node {

class DeformableSurfaceNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    // A nodelet that cannot run stays idle: an exception would end the manager.
    try {
      node_ = std::make_unique<SurfaceNode>(getNodeHandle(), getPrivateNodeHandle(), readNodeParameters(getPrivateNodeHandle()));
    } catch (const InputError& error) {
      NODELET_FATAL_STREAM("the parameters below " << getPrivateNodeHandle().getNamespace() << " are not accepted:\n"
                                                   << error.what());
    } catch (const std::exception& error) {
      NODELET_FATAL_STREAM("the nodelet cannot run: " << error.what());
    }
  }

  std::unique_ptr<SurfaceNode> node_;
};

}  // namespace deformable_surface::node

PLUGINLIB_EXPORT_CLASS(deformable_surface::node::DeformableSurfaceNodelet, nodelet::Nodelet)
