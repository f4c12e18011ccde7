// The interactive markers for work on a surface in RViz: their looks, and which parts can be
// dragged. marker_server.h answers them.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/ros/convert/text_place.h"
#include "deformable_surface/tool/tool.h"

#include <geometry_msgs/Pose.h>
#include <shape_msgs/SolidPrimitive.h>
#include <std_msgs/Header.h>
#include <visualization_msgs/InteractiveMarker.h>

#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

namespace deformable_surface::node {

/// A tool kept by this program: the message for ~tools, and its marker.
struct MarkedTool {
  std::string id;
  std::uint8_t mode = 0;  // as in Tool.msg
  shape_msgs::SolidPrimitive primitive;
  geometry_msgs::Pose pose;
  double strength = 0.0;  // N, of one that moves
};

// Names of the markers that always exist; the others are the ids of tools.
constexpr char kSurfaceHandle[] = "surface", kSpotHandle[] = "spot", kPanelHandle[] = "panel";

// All headers must have the stamp zero: RViz then answers in the header's frame.

/// The surface, to be clicked and dragged in the plane of the screen: faint balls at points (m), at most a few thousand.
/// diameter: m, > 0.
visualization_msgs::InteractiveMarker makeSurfaceHandle(const std_msgs::Header& header, const Points& points, double diameter);

/// The place that was clicked last: a ball of the size (m, > 0) with an arrow along each axis.
visualization_msgs::InteractiveMarker makeSpotHandle(const std_msgs::Header& header, const Vec3& point, double size);

/// A tool: its shape in the colour of its mode, which can be dragged, and rings and arrows to turn and move it.
visualization_msgs::InteractiveMarker makeToolHandle(const std_msgs::Header& header, const MarkedTool& tool);

/// A button of the size (m, > 0) with a sentence below it, empty for none.
visualization_msgs::InteractiveMarker makePanelHandle(const std_msgs::Header& header, const TextPlace& place, double size,
                                                      const std::string& sentence);

geometry_msgs::Pose makePose(const Vec3& position);
geometry_msgs::Pose makePose(const tool::Pose& pose);
/// Throws InputError for numbers that are not finite and an orientation that is not of unit length.
tool::Pose toPose(const geometry_msgs::Pose& pose);
/// type and sizes: as of shape_msgs/SolidPrimitive.
shape_msgs::SolidPrimitive makePrimitive(std::uint8_t type, std::initializer_list<double> sizes);

/// The largest extent of a box, sphere, cylinder or cone, m.
double findExtent(const shape_msgs::SolidPrimitive& primitive);

}  // namespace deformable_surface::node
