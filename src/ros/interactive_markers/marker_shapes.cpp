#include "marker_shapes.h"

#include "deformable_surface/ros/convert/color_scale.h"
#include "deformable_surface/ros/convert/frames.h"
#include "deformable_surface/tool/tool_modes.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::node {
namespace {

using shape_msgs::SolidPrimitive;
using visualization_msgs::InteractiveMarker;
using visualization_msgs::InteractiveMarkerControl;
using visualization_msgs::Marker;

// A message of a few tens of kilobytes, and little load for RViz even when it draws in software.
constexpr std::size_t kMaxBalls = 2000;
// Visible, and so is what lies below it.
constexpr float kFaint = 0.04f;
// Handles are larger than what they move.
constexpr double kHandleShare = 1.5;

geometry_msgs::Vector3 makeScale(double x, double y, double z) {
  geometry_msgs::Vector3 scale;
  scale.x = x;
  scale.y = y;
  scale.z = z;
  return scale;
}

Marker makeMarker(int type, const geometry_msgs::Vector3& scale, const std_msgs::ColorRGBA& color) {
  Marker marker;
  marker.type = type;
  marker.pose.orientation.w = 1.0;
  marker.scale = scale;
  marker.color = color;
  return marker;
}

InteractiveMarkerControl makeControl(const std::string& name, std::uint8_t mode) {
  InteractiveMarkerControl control;
  control.name = name;
  control.interaction_mode = mode;
  control.orientation.w = 1.0;
  return control;
}

InteractiveMarkerControl makeControl(const std::string& name, std::uint8_t mode, const Marker& marker) {
  InteractiveMarkerControl control = makeControl(name, mode);
  control.always_visible = true;
  control.markers.push_back(marker);
  return control;
}

/// RViz draws arrows and rings itself for controls without markers, along the control's own x axis.
void addAxes(std::uint8_t mode, const std::string& name, InteractiveMarker& marker) {
  const double s = std::sqrt(0.5);
  const struct {
    const char* name;
    double x, y, z;
  } axes[] = {{"x", s, 0.0, 0.0}, {"y", 0.0, 0.0, s}, {"z", 0.0, s, 0.0}};
  for (const auto& axis : axes) {
    InteractiveMarkerControl control = makeControl(name + "_" + axis.name, mode);
    control.orientation.w = s;
    control.orientation.x = axis.x;
    control.orientation.y = axis.y;
    control.orientation.z = axis.z;
    marker.controls.push_back(control);
  }
}

InteractiveMarker makeInteractive(const std_msgs::Header& header, const std::string& name, const geometry_msgs::Pose& pose,
                                  double scale) {
  InteractiveMarker marker;
  marker.header = header;
  marker.name = name;
  marker.pose = pose;
  marker.scale = static_cast<float>(scale);
  return marker;
}

// The colours of ~markers, slightly transparent.
std_msgs::ColorRGBA chooseColor(std::uint8_t mode) {
  constexpr float kAlpha = 0.6f;
  const auto& [red, green, blue] = tool::findMode(mode)->color;
  return makeColor(red, green, blue, kAlpha);
}

// This program makes no cones.
Marker makeShape(const SolidPrimitive& primitive, const std_msgs::ColorRGBA& color) {
  const auto& d = primitive.dimensions;
  switch (primitive.type) {
    case SolidPrimitive::BOX: return makeMarker(Marker::CUBE, makeScale(d[0], d[1], d[2]), color);
    case SolidPrimitive::SPHERE: return makeMarker(Marker::SPHERE, makeScale(2.0 * d[0], 2.0 * d[0], 2.0 * d[0]), color);
    default: return makeMarker(Marker::CYLINDER, makeScale(2.0 * d[1], 2.0 * d[1], d[0]), color);
  }
}

}  // namespace

geometry_msgs::Pose makePose(const Vec3& position) {
  geometry_msgs::Pose pose;
  pose.position.x = position.x();
  pose.position.y = position.y();
  pose.position.z = position.z();
  pose.orientation.w = 1.0;
  return pose;
}

geometry_msgs::Pose makePose(const tool::Pose& pose) {
  geometry_msgs::Pose message = makePose(pose.position);
  message.orientation.w = pose.orientation.w();
  message.orientation.x = pose.orientation.x();
  message.orientation.y = pose.orientation.y();
  message.orientation.z = pose.orientation.z();
  return message;
}

tool::Pose toPose(const geometry_msgs::Pose& pose) {
  const Eigen::Isometry3d T_surface_tool = readPose(pose);
  return {T_surface_tool.translation(), Eigen::Quaterniond(T_surface_tool.linear())};
}

shape_msgs::SolidPrimitive makePrimitive(std::uint8_t type, std::initializer_list<double> sizes) {
  shape_msgs::SolidPrimitive primitive;
  primitive.type = type;
  primitive.dimensions.assign(sizes.begin(), sizes.end());
  return primitive;
}

double findExtent(const SolidPrimitive& primitive) {
  const auto& d = primitive.dimensions;
  if (primitive.type == SolidPrimitive::BOX) return *std::max_element(d.begin(), d.end());
  if (primitive.type == SolidPrimitive::SPHERE) return 2.0 * d[0];
  return std::max(d[0], 2.0 * d[1]);
}

InteractiveMarker makeSurfaceHandle(const std_msgs::Header& header, const Points& points, double diameter) {
  const std::size_t stride = std::max<std::size_t>(1, (points.size() + kMaxBalls - 1) / kMaxBalls);
  // Fewer balls cover the same area when they are larger.
  const double width = diameter * std::sqrt(static_cast<double>(stride));
  Marker balls = makeMarker(Marker::SPHERE_LIST, makeScale(width, width, width), makeColor(0.9f, 0.9f, 1.0f, kFaint));
  for (std::size_t i = 0; i < points.size(); i += stride) {
    geometry_msgs::Point p;
    p.x = points[i].x();
    p.y = points[i].y();
    p.z = points[i].z();
    balls.points.push_back(p);
  }
  InteractiveMarker marker = makeInteractive(header, kSurfaceHandle, makePose(Vec3::Zero()), diameter);
  marker.controls.push_back(makeControl("pull", InteractiveMarkerControl::MOVE_3D, balls));
  return marker;
}

InteractiveMarker makeSpotHandle(const std_msgs::Header& header, const Vec3& point, double size) {
  InteractiveMarker marker = makeInteractive(header, kSpotHandle, makePose(point), 3.0 * size);
  const Marker ball = makeMarker(Marker::SPHERE, makeScale(size, size, size), makeColor(0.1f, 0.9f, 0.9f, 0.9f));
  marker.controls.push_back(makeControl("pull", InteractiveMarkerControl::MOVE_3D, ball));
  addAxes(InteractiveMarkerControl::MOVE_AXIS, "pull", marker);
  return marker;
}

InteractiveMarker makeToolHandle(const std_msgs::Header& header, const MarkedTool& tool) {
  InteractiveMarker marker = makeInteractive(header, tool.id, tool.pose, kHandleShare * findExtent(tool.primitive));
  marker.description = tool.id;
  // Slightly larger than the tool as ~markers draws it, so that the two do not flicker.
  Marker shape = makeShape(tool.primitive, chooseColor(tool.mode));
  for (double* size : {&shape.scale.x, &shape.scale.y, &shape.scale.z}) *size *= 1.02;
  marker.controls.push_back(makeControl("move", InteractiveMarkerControl::MOVE_3D, shape));
  addAxes(InteractiveMarkerControl::MOVE_AXIS, "move", marker);
  addAxes(InteractiveMarkerControl::ROTATE_AXIS, "turn", marker);
  return marker;
}

InteractiveMarker makePanelHandle(const std_msgs::Header& header, const TextPlace& place, double size,
                                  const std::string& sentence) {
  InteractiveMarker marker = makeInteractive(header, kPanelHandle, makePose(place.anchor), size);
  const Marker button = makeMarker(Marker::CUBE, makeScale(size, size, size), makeColor(0.3f, 0.6f, 0.9f, 0.9f));
  marker.controls.push_back(makeControl("menu", InteractiveMarkerControl::MENU, button));
  if (sentence.empty()) return marker;
  // Not the marker's description: RViz draws its letters much smaller than the button.
  Marker text = makeMarker(Marker::TEXT_VIEW_FACING, makeScale(1.0, 1.0, place.height), makeColor(1.0f, 1.0f, 1.0f, 1.0f));
  text.text = showBelow(sentence);
  marker.controls[0].markers.push_back(text);
  return marker;
}

}  // namespace deformable_surface::node
