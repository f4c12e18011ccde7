// The executable deformable_surface_interactive_markers: interactive markers in RViz for the surface of a running node. It is
// also installed under its old name, deformable_surface_hand.
#include "marker_server.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/io/scene_old_names.h"
#include "deformable_surface/ros/convert/xmlrpc_value.h"

#include <ros/ros.h>

#include <csignal>
#include <cstdio>
#include <string>

namespace {

namespace io = deformable_surface::io;
using deformable_surface::node::MarkerParams;

constexpr char kName[] = "deformable_surface_interactive_markers", kOldName[] = "deformable_surface_hand";

constexpr char kHelp[] = R"(deformable_surface_interactive_markers: pulls and pins a deformable surface and moves tools, in RViz.

  rosrun deformable_surface deformable_surface_interactive_markers [_surface:=NAME] [_rate:=HZ] [_radius:=M]

Parameters (private): surface (deformable_surface), rate (10 Hz), radius (auto, m), strength (0 = any, N),
  heat (500 K), attraction (10 N/m), speed (auto, m/s)
In RViz: the display InteractiveMarkers with the topic ~update. docs/rviz.md says what can be done.
)";

// As roscpp does for SIGINT.
void handleSignal(int) { ros::requestShutdown(); }

bool isCalledByOldName(const std::string& program) { return program.substr(program.rfind('/') + 1) == kOldName; }

MarkerParams readMarkerParams(const ros::NodeHandle& node) {
  XmlRpc::XmlRpcValue tree;
  MarkerParams params;
  if (!node.getParam(node.getNamespace(), tree)) return params;
  std::string all;
  for (const std::string& problem : readParams(deformable_surface::node::toValue(tree), params)) all += "\n" + problem;
  if (!all.empty()) throw deformable_surface::InputError(all);
  return params;
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const bool has_old_name = isCalledByOldName(argv[0]);
  ros::init(argc, argv, has_old_name ? kOldName : kName);
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--help" || argument == "-h") {
      std::fputs(kHelp, stdout);
      return 0;
    }
    std::fprintf(stderr, "found the argument '%s'; accepted: --help, and ROS remappings such as _surface:=NAME\n", argv[i]);
    return 2;
  }
  const ros::NodeHandle node, private_node("~");
  std::signal(SIGTERM, handleSignal);
  if (has_old_name)
    ROS_WARN_STREAM(io::describeNewName(kOldName, kName) << "; the launch argument hand is now called interactive_markers");
  try {
    const deformable_surface::node::MarkerServer server(readMarkerParams(private_node));
    ros::spin();
  } catch (const deformable_surface::InputError& error) {
    ROS_FATAL_STREAM("the parameters below " << private_node.getNamespace() << " are not accepted:" << error.what());
    return 2;
  }
  return 0;
}
