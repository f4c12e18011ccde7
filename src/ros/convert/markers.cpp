// Single markers. All of them are lists, except the arrows, so that RViz has to keep few of them.
#include "deformable_surface/ros/convert/markers.h"

#include "deformable_surface/model/curved_triangles.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace deformable_surface::node {
namespace {

using visualization_msgs::Marker;

// Shaft, head and head length as shares of an arrow's length.
constexpr double kShaftShare = 0.05, kHeadShare = 0.12, kHeadLengthShare = 0.25;

// RViz's own cone has about as many sides.
constexpr int kConeSides = 24;
// A plane is drawn as a plate of this share of its width: it looks like a plane, and has two sides.
constexpr double kPlateShare = 1e-3;
// Row of the legend above the surface; the statistics are below it.
constexpr int kLegendRow = 1;

Marker makeMarker(const std_msgs::Header& header, const std::string& ns, int id, int type) {
  Marker marker;
  marker.header = header;
  marker.ns = ns;
  marker.id = id;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.color = makeColor(1.0f, 1.0f, 1.0f);
  return marker;
}

geometry_msgs::Point toPoint(const Vec3& p) {
  geometry_msgs::Point point;
  point.x = p.x();
  point.y = p.y();
  point.z = p.z();
  return point;
}

/// Corner k of n on the unit circle in the x-y plane.
Vec3 onCircle(int k, int n) {
  const double angle = 2.0 * kPi * (k % n) / n;
  return {std::cos(angle), std::sin(angle), 0.0};
}

std_msgs::ColorRGBA chooseColor(tool::Mode mode) {
  const auto& [red, green, blue] = tool::infoOf(mode).color;
  return makeColor(red, green, blue);
}

void setPose(const tool::Pose& pose, Marker& marker) {
  marker.pose.position = toPoint(pose.position);
  marker.pose.orientation.x = pose.orientation.x();
  marker.pose.orientation.y = pose.orientation.y();
  marker.pose.orientation.z = pose.orientation.z();
  marker.pose.orientation.w = pose.orientation.w();
}

void setScale(const Vec3& scale, Marker& marker) {
  marker.scale.x = scale.x();
  marker.scale.y = scale.y();
  marker.scale.z = scale.z();
}

/// Makes the marker look like a tool at its pose.
void setShape(const geometry::Solid& solid, const tool::Pose& pose, double extent, Marker& marker) {
  using Kind = geometry::Solid::Kind;
  const double width = 2.0 * solid.radius;
  setPose(pose, marker);
  switch (solid.kind) {
    case Kind::kSphere:
      marker.type = Marker::SPHERE;
      setScale(Vec3::Constant(width), marker);
      return;
    case Kind::kBox:
      marker.type = Marker::CUBE;
      setScale(solid.size, marker);
      return;
    case Kind::kCylinder:
      marker.type = Marker::CYLINDER;
      setScale({width, width, solid.height}, marker);
      return;
    case Kind::kCone: {
      marker.type = Marker::TRIANGLE_LIST;
      const Vec3 tip(0.0, 0.0, 0.5 * solid.height), base = -tip;
      const auto corner = [&](int k) { return toPoint(base + solid.radius * onCircle(k, kConeSides)); };
      for (int k = 0; k < kConeSides; ++k) {
        marker.points.insert(marker.points.end(), {corner(k), corner(k + 1), toPoint(tip)});
        marker.points.insert(marker.points.end(), {corner(k + 1), corner(k), toPoint(base)});
      }
      return;
    }
    case Kind::kMesh:
      marker.type = Marker::TRIANGLE_LIST;
      for (const geometry::Polyhedron::Triangle& triangle : solid.mesh->triangles())
        for (Index corner : triangle) marker.points.push_back(toPoint(solid.mesh->vertices()[corner]));
      return;
    case Kind::kPlane: {
      // The plate lies below the plane, across its normal.
      marker.type = Marker::CUBE;
      const Vec3 normal = solid.normal.normalized();
      const Vec3 middle = (solid.offset - 0.5 * kPlateShare * extent) * normal;
      const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), normal);
      setPose({pose.position + pose.orientation * middle, (pose.orientation * turn).normalized()}, marker);
      setScale({extent, extent, kPlateShare * extent}, marker);
      return;
    }
  }
}

/// RViz refuses lists without points: a marker with nothing to show deletes itself.
Marker finish(Marker marker) {
  if (marker.points.empty()) marker.action = Marker::DELETE;
  return marker;
}

/// RViz only lights markers of one colour. Here the light is part of the colours: a lamp above the scene, a little to
/// one side, that shines on both sides of a surface.
std_msgs::ColorRGBA shade(std_msgs::ColorRGBA color, const Vec3& normal) {
  constexpr double kAmbient = 0.4;
  const Vec3 lamp = Vec3(0.35, -0.45, 0.82).normalized();
  const double length = normal.norm();
  const auto light = static_cast<float>(length > 0.0 ? kAmbient + (1.0 - kAmbient) * std::abs(normal.dot(lamp)) / length : 1.0);
  return makeColor(light * color.r, light * color.g, light * color.b);
}

void appendCorner(Index i, const Points& positions, const std::vector<double>& values, double full_scale, Marker& marker) {
  marker.points.push_back(toPoint(positions[i]));
  marker.colors.push_back(colorOf(values[i] / full_scale));
}

Marker drawTriangles(const std_msgs::Header& header, const Points& positions, const Points& normals,
                     const std::vector<model::WeightedTriangle>& triangles, const std::vector<double>& values,
                     double full_scale) {
  Marker marker = makeMarker(header, "surface", 0, Marker::TRIANGLE_LIST);
  marker.points.reserve(3 * triangles.size());
  marker.colors.reserve(3 * triangles.size());
  for (const model::WeightedTriangle& triangle : triangles) {
    for (const Index corner : triangle.corner) {
      marker.points.push_back(toPoint(positions[corner]));
      marker.colors.push_back(shade(colorOf(values[corner] / full_scale), normals[corner]));
    }
  }
  return finish(std::move(marker));
}

}  // namespace

Marker makeLinksMarker(const std_msgs::Header& header, const std::string& ns, const Points& positions,
                       const std::vector<std::pair<Index, Index>>& links, const std::vector<double>& values, double full_scale,
                       double width) {
  Marker marker = makeMarker(header, ns, 0, Marker::LINE_LIST);
  marker.scale.x = width;
  marker.points.reserve(2 * links.size());
  marker.colors.reserve(2 * links.size());
  for (const auto& [a, b] : links) {
    appendCorner(a, positions, values, full_scale, marker);
    appendCorner(b, positions, values, full_scale, marker);
  }
  return finish(std::move(marker));
}

Marker makeSurfaceMarker(const std_msgs::Header& header, const Points& positions,
                         const std::vector<model::WeightedTriangle>& triangles, const std::vector<double>& values,
                         double full_scale) {
  // Triangles need not all face the same way.
  Points normals(positions.size(), Vec3::Zero());
  for (const model::WeightedTriangle& triangle : triangles) {
    const auto& [a, b, c] = triangle.corner;
    const Vec3 normal = (positions[b] - positions[a]).cross(positions[c] - positions[a]);
    for (const Index corner : {a, b, c}) normals[corner] += normals[corner].dot(normal) < 0.0 ? Vec3(-normal) : normal;
  }
  return drawTriangles(header, positions, normals, triangles, values, full_scale);
}

Marker makePatchesMarker(const std_msgs::Header& header, const Points& positions, const Orientations& orientations,
                         const std::vector<model::WeightedTriangle>& triangles, const std::vector<double>& values,
                         double full_scale, Index pieces) {
  Points normals;
  normals.reserve(orientations.size());
  for (const Quaternion& q : orientations) normals.push_back(q * Vec3::UnitZ());
  const model::CurvedTriangles curved = model::curveTriangles(positions, normals, triangles, pieces, values);
  return drawTriangles(header, curved.positions, curved.normals, curved.triangles, curved.values, full_scale);
}

Marker makeWireframeMarker(const std_msgs::Header& header, const Points& positions,
                           const std::vector<std::pair<Index, Index>>& edges, double width) {
  Marker marker = makeMarker(header, "wireframe", 0, Marker::LINE_LIST);
  marker.scale.x = width;
  marker.color = makeColor(0.1f, 0.1f, 0.1f);
  marker.points.reserve(2 * edges.size());
  for (const auto& [a, b] : edges) {
    marker.points.push_back(toPoint(positions[a]));
    marker.points.push_back(toPoint(positions[b]));
  }
  return finish(std::move(marker));
}

Marker makeContactsMarker(const std_msgs::Header& header, const std::vector<std::pair<Vec3, Vec3>>& touches, double length,
                          double width) {
  Marker marker = makeMarker(header, "contact_points", 0, Marker::LINE_LIST);
  marker.scale.x = width;
  marker.color = makeColor(0.9f, 0.1f, 0.2f);
  double largest = 0.0;
  for (const auto& [place, force] : touches) largest = std::max(largest, force.norm());
  for (const auto& [place, force] : touches) {
    if (!(largest > 0.0)) break;
    marker.points.push_back(toPoint(place));
    marker.points.push_back(toPoint(place + length / largest * force));
  }
  return finish(std::move(marker));
}

Marker makePinsMarker(const std_msgs::Header& header, const Points& positions, const std::vector<char>& pinned, double diameter) {
  Marker marker = makeMarker(header, "pins", 0, Marker::SPHERE_LIST);
  marker.scale.x = marker.scale.y = marker.scale.z = diameter;
  marker.color = makeColor(0.8f, 0.1f, 0.6f);
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (pinned[i]) marker.points.push_back(toPoint(positions[i]));
  return finish(std::move(marker));
}

int addForceMarkers(const std_msgs::Header& header, const std::string& ns, const std_msgs::ColorRGBA& color,
                    const std::vector<std::pair<Vec3, Vec3>>& forces, double length, int num_before,
                    visualization_msgs::MarkerArray& markers) {
  const int num_shown = static_cast<int>(std::min<std::size_t>(forces.size(), kMaxArrows));
  double largest = 0.0;
  for (int f = 0; f < num_shown; ++f) largest = std::max(largest, forces[f].second.norm());
  for (int f = 0; f < std::max(num_shown, num_before); ++f) {
    Marker marker = makeMarker(header, ns, f, Marker::ARROW);
    const double share = f < num_shown && largest > 0.0 ? forces[f].second.norm() / largest : 0.0;
    if (share > 0.0) {
      const auto& [point, force] = forces[f];
      marker.points = {toPoint(point), toPoint(point + length / largest * force)};
      marker.scale.x = kShaftShare * length;
      marker.scale.y = kHeadShare * length;
      marker.scale.z = kHeadLengthShare * length * share;
      marker.color = color;
    }
    markers.markers.push_back(finish(std::move(marker)));
  }
  return num_shown;
}

int addToolMarkers(const std_msgs::Header& header, const std::vector<tool::ToolParams>& tools, double time, double extent,
                   int num_before, visualization_msgs::MarkerArray& markers) {
  const int num_tools = static_cast<int>(tools.size());
  for (int t = 0; t < std::max(num_tools, num_before); ++t) {
    Marker marker = makeMarker(header, "tools", t, Marker::SPHERE);
    if (t < num_tools && tool::isActive(tools[t], time)) {
      marker.color = chooseColor(tools[t].mode);
      setShape(tools[t].shape, tool::interpolate(tools[t].path, time), extent, marker);
    } else {
      marker.action = Marker::DELETE;
    }
    markers.markers.push_back(std::move(marker));
  }
  return num_tools;
}

Marker makeTextMarker(const std_msgs::Header& header, const std::string& ns, int id, const TextPlace& place,
                      const std::string& text) {
  Marker marker = makeMarker(header, ns, id, Marker::TEXT_VIEW_FACING);
  marker.pose.position = toPoint(place.anchor);
  marker.scale.z = place.height;
  marker.text = text;
  return marker;
}

Marker makeStatisticsMarker(const std_msgs::Header& header, const simulation::Statistics& statistics, const TextPlace& place) {
  std::ostringstream text;
  // Nothing that depends on the machine: recorded markers are bit-identical.
  text << std::fixed << std::setprecision(2) << statistics.simulation_time << " s\n"
       << statistics.simulation_points << " of " << statistics.points << " points, " << statistics.substeps << " sub-steps\n"
       << "largest stretch " << 100.0 * statistics.max_stretch << " %";
  if (std::isfinite(statistics.error_estimate)) text << ", error " << 1000.0 * statistics.error_estimate << " mm";
  if (std::isfinite(statistics.error_estimate) && !statistics.error_bounded) text << ", no bound";
  if (statistics.may_buckle) text << ", may buckle";
  if (statistics.has_snapped) text << ", snapped: reset brings it back";
  return makeTextMarker(header, "statistics", 0, place, showFromRow(kLegendRow + 1, text.str()));
}

void addLegendMarkers(const std_msgs::Header& header, const std::string& ns, const std::string& quantity, const std::string& unit,
                      double full_scale, const TextPlace& place, visualization_msgs::MarkerArray& markers) {
  // RViz gives a text one colour and centres it: blanks after it move it to the left, blanks before it to the right.
  constexpr int kNumbers = 5, kApart = 10;
  for (int k = 0; k < kNumbers; ++k) {
    const double share = static_cast<double>(k) / (kNumbers - 1);
    std::ostringstream number;
    number << std::setprecision(3) << share * full_scale << ' ' << unit;
    const std::string before(kApart * std::max(0, 2 * k - kNumbers + 1), ' ');
    const std::string after(kApart * std::max(0, kNumbers - 1 - 2 * k), ' ');
    markers.markers.push_back(makeTextMarker(header, ns, k, place, showFromRow(kLegendRow, before + number.str() + after)));
    markers.markers.back().color = colorOf(share);
  }
  markers.markers.push_back(makeTextMarker(header, ns, kNumbers, place, showFromRow(kLegendRow - 1, quantity)));
}

Marker makeDiscsMarker(const std_msgs::Header& header, const Points& positions, const Orientations& orientations,
                       const std::vector<double>& values, double full_scale, double radius) {
  Marker marker = makeMarker(header, "discs", 0, Marker::TRIANGLE_LIST);
  constexpr int kCorners = 6;
  marker.points.reserve(3 * kCorners * positions.size());
  marker.colors.reserve(3 * kCorners * positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const auto corner = [&](int k) { return toPoint(positions[i] + orientations[i] * (radius * onCircle(k, kCorners))); };
    for (int k = 0; k < kCorners; ++k) {
      marker.points.insert(marker.points.end(), {toPoint(positions[i]), corner(k), corner(k + 1)});
      marker.colors.insert(marker.colors.end(), 3, shade(colorOf(values[i] / full_scale), orientations[i] * Vec3::UnitZ()));
    }
  }
  return finish(std::move(marker));
}

Marker makeAxesMarker(const std_msgs::Header& header, const Points& positions, const Orientations& orientations, double length,
                      double width) {
  Marker marker = makeMarker(header, "axes", 0, Marker::LINE_LIST);
  marker.scale.x = width;
  for (std::size_t i = 0; i < positions.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 unit = Vec3::Unit(axis);
      const Vec3 end = positions[i] + length * (orientations[i] * unit);
      marker.points.insert(marker.points.end(), {toPoint(positions[i]), toPoint(end)});
      marker.colors.insert(marker.colors.end(), 2, makeColor(float(unit.x()), float(unit.y()), float(unit.z())));
    }
  return finish(std::move(marker));
}

}  // namespace deformable_surface::node
