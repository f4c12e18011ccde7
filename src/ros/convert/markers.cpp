// Markers of a simulation. All of them are lists, except the arrows, so that RViz has few of them to keep.
#include "deformable_surface/ros/convert/markers.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

namespace deformable_surface::node {
namespace {

using visualization_msgs::Marker;

// Full colour scale: strains of cloth and rubber sheets in use lie below it, and half of it is plainly visible.
constexpr double kFullStrain = 0.1;
// Displacements saturate at this share of the surface's extent.
constexpr double kFullDisplacementShare = 0.25;
// Sizes as shares of the spacing: lines thin enough not to hide the surface, balls that do not touch.
constexpr double kLineWidthShare = 0.05, kPinShare = 0.5;
// Discs that nearly touch, and axes that do not reach the next particle.
constexpr double kDiscShare = 0.45, kAxisShare = 0.4, kContactShare = 2.0;
// The longest arrow, as a share of the surface's extent.
constexpr double kArrowShare = 0.3;
// Shaft, head and head length as shares of an arrow's length.
constexpr double kShaftShare = 0.05, kHeadShare = 0.12, kHeadLengthShare = 0.25;

// The side of a cone in RViz's own primitives has about as many parts.
constexpr int kConeSides = 24;
// A plane is drawn as a plate of this share of its width: seen as a plane, and still with two sides.
constexpr double kPlateShare = 1e-3;
// Of the text above the surface; the statistics stand below it.
constexpr int kLegendRow = 1;

const Vec3 kNowhere = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());

std_msgs::ColorRGBA makeColor(float r, float g, float b) {
  std_msgs::ColorRGBA color;
  color.r = r;
  color.g = g;
  color.b = b;
  color.a = 1.0f;
  return color;
}

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

/// RViz refuses lists without points: one with nothing to show deletes itself.
Marker finish(Marker marker) {
  if (marker.points.empty()) marker.action = Marker::DELETE;
  return marker;
}

/// RViz gives light only to what has one colour, so that here the light is in the colours: a lamp above the scene, a little to
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

/// Every edge of the triangles once, in the order of the points.
std::vector<std::pair<Index, Index>> collectEdges(const std::vector<model::WeightedTriangle>& triangles) {
  std::vector<std::pair<Index, Index>> edges;
  for (const model::WeightedTriangle& triangle : triangles)
    for (int c = 0; c < 3; ++c) edges.push_back(std::minmax({triangle.corner[c], triangle.corner[(c + 1) % 3]}));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
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
  // Nothing that depends on the machine: recorded markers are the same, bit for bit.
  text << std::fixed << std::setprecision(2) << statistics.simulation_time << " s\n"
       << statistics.simulation_points << " of " << statistics.points << " points, " << statistics.substeps << " sub-steps\n"
       << "largest stretch " << 100.0 * statistics.max_stretch << " %";
  if (std::isfinite(statistics.error_estimate)) text << ", error " << 1000.0 * statistics.error_estimate << " mm";
  if (statistics.may_buckle) text << ", may buckle";
  if (statistics.has_snapped) text << ", snapped: reset brings it back";
  return makeTextMarker(header, "statistics", 0, place, showFromRow(kLegendRow + 1, text.str()));
}

void addLegendMarkers(const std_msgs::Header& header, const std::string& ns, const std::string& quantity, const std::string& unit,
                      double full_scale, const TextPlace& place, visualization_msgs::MarkerArray& markers) {
  // RViz gives a text one colour, and centres it: blanks behind it move it to the left, blanks in front to the right.
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

SimulationMarkers::SimulationMarkers(const simulation::Simulation& simulation, const std::string& frame_id) {
  const model::State& state = simulation.state();
  if (const model::Links* drawn = simulation.model().links()) drawn->refreshDisplay(state);
  edges_ = collectEdges(trianglesOf(simulation.model()));
  if (state.positions.empty()) return;  // all particles are gone
  const Box box = findMainBox(state.positions);
  extent_ = box.extent();
  text_place_ = placeText(box, frame_id);
  // Without any link the extent shared among the points has to do.
  const auto& links = edges_.empty() ? stretchLinksOf(simulation.model()) : edges_;
  for (const auto& [a, b] : links) spacing_ += (state.positions[a] - state.positions[b]).norm() / links.size();
  if (links.empty()) spacing_ = extent_ / state.positions.size();

  rest_positions_ = state.positions;
  if (state.traits.empty()) return;
  rest_positions_.assign(state.next_id, kNowhere);
  for (Index i = 0; i < state.size(); ++i) rest_positions_[state.traits[i].id] = state.positions[i];
}

Vec3 SimulationMarkers::findRest(Index id) const {
  return id < static_cast<Index>(rest_positions_.size()) ? rest_positions_[id] : kNowhere;
}

void SimulationMarkers::make(const std_msgs::Header& header, const simulation::Simulation& simulation,
                             visualization_msgs::MarkerArray& markers) {
  const model::State& state = simulation.state();
  const model::DeformableModel& model = simulation.model();
  const Points& positions = state.positions;
  const bool is_oriented = isOriented(model);
  if (model.links()) model.links()->refreshDisplay(state);
  // Triangles come and go with particles, and go where a surface is cut.
  if (is_oriented || trianglesOf(model).size() != num_triangles_) edges_ = collectEdges(trianglesOf(model));
  num_triangles_ = trianglesOf(model).size();
  computePointStrain(model, state, strain_);
  displacement_.resize(positions.size());
  for (Index i = 0; i < state.size(); ++i)
    displacement_[i] = (positions[i] - findRest(state.traits.empty() ? i : state.traits[i].id)).norm();

  const double width = kLineWidthShare * spacing_;
  markers.markers.clear();
  markers.markers.push_back(
      makeLinksMarker(header, "stretch_springs", positions, stretchLinksOf(model), strain_, kFullStrain, width));
  markers.markers.push_back(
      makeLinksMarker(header, "bending_springs", positions, bendLinksOf(model), strain_, kFullStrain, width));
  markers.markers.push_back(
      makeSurfaceMarker(header, positions, trianglesOf(model), displacement_, kFullDisplacementShare * extent_));
  markers.markers.push_back(makeWireframeMarker(header, positions, edges_, width));
  markers.markers.push_back(makePinsMarker(header, positions, simulation.pinned(), kPinShare * spacing_));
  std::vector<std::pair<Vec3, Vec3>> touches;
  for (const simulation::Contact& touch : simulation.contacts()) touches.emplace_back(touch.position, touch.force);
  for (const simulation::SelfTouch& touch : simulation.selfTouches()) touches.emplace_back(touch.position, touch.force);
  markers.markers.push_back(makeContactsMarker(header, touches, kContactShare * spacing_, width));
  if (is_oriented) {
    markers.markers.push_back(
        makeDiscsMarker(header, positions, state.orientations, strain_, kFullStrain, kDiscShare * spacing_));
    Orientations frames;
    for (Index i = 0; i < state.size(); ++i) frames.push_back(state.frame(i));
    markers.markers.push_back(makeAxesMarker(header, positions, frames, kAxisShare * spacing_, width));
  }
  // Who joins a bag in its middle, or lost a message, has to be told of all that is gone.
  const auto atMost = [](int& most, int now) { most = std::max(most, now); };
  atMost(num_tools_, addToolMarkers(header, simulation.tools(), simulation.time(), extent_, num_tools_, markers));
  const double arrow = kArrowShare * extent_;
  const std_msgs::ColorRGBA orange = makeColor(1.0f, 0.5f, 0.0f), red = makeColor(0.9f, 0.1f, 0.2f);
  atMost(num_arrows_, addForceMarkers(header, "forces", orange, simulation.activeForces(), arrow, num_arrows_, markers));
  std::vector<std::pair<Vec3, Vec3>> contacts;
  const std::vector<simulation::ToolReaction> reactions = simulation.toolReactions();
  for (std::size_t t = 0; t < reactions.size(); ++t) {
    const tool::Pose pose = tool::interpolate(simulation.tools()[t].path, simulation.time());
    contacts.emplace_back(pose.position, pose.orientation * reactions[t].force);
  }
  atMost(num_contacts_, addForceMarkers(header, "contacts", red, contacts, arrow, num_contacts_, markers));
  addLegendMarkers(header, "strain_legend", "strain", "%", 100.0 * kFullStrain, text_place_, markers);
  addLegendMarkers(header, "displacement_legend", "displacement", "mm", 1000.0 * kFullDisplacementShare * extent_, text_place_,
                   markers);
  markers.markers.push_back(makeStatisticsMarker(header, simulation.statistics(), text_place_));
}

}  // namespace deformable_surface::node
