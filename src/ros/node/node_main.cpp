// The executable deformable_surface_node: reads the parameters, runs the node, ends cleanly on both signals.
#include "interface_page.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/ros/node/surface_node.h"

#include <ros/ros.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <string>

namespace {

constexpr char kHelp[] = R"(deformable_surface_node: simulates the deformable surface that a point cloud describes.

  rosparam load SCENE.yaml /deformable_surface
  rosrun deformable_surface deformable_surface_node [__name:=NAME] [~cloud_in:=TOPIC]

Parameters: the private ones are the keys of a scene file, docs/parameters.md; an unknown key or a wrong value ends the node.
)";

// As roscpp does for SIGINT.
void handleSignal(int) { ros::requestShutdown(); }

}  // namespace

int main(int argc, char** argv) {
  // roslaunch and scripts redirect the output; its readers must not wait for the end.
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  ros::init(argc, argv, "deformable_surface");
  // ros::init() has removed the arguments of ROS.
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--help" || argument == "-h") {
      std::fputs((kHelp + deformable_surface::node::interfaceHelp()).c_str(), stdout);
      return 0;
    }
    std::fprintf(stderr, "found the argument '%s'; accepted: --help, and ROS remappings such as __name:=NAME\n", argv[i]);
    return 2;
  }
  ros::NodeHandle node, private_node("~");
  std::signal(SIGTERM, handleSignal);
  try {
    const auto params = deformable_surface::node::readNodeParameters(private_node);
    const deformable_surface::node::SurfaceNode surface_node(node, private_node, params);
    ros::spin();
  } catch (const deformable_surface::InputError& error) {
    ROS_FATAL_STREAM("the parameters below " << private_node.getNamespace() << " are not accepted:\n" << error.what());
    return 2;
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM("the node cannot run: " << error.what());
    return 1;
  }
  return 0;
}
