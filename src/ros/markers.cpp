// Markers of a simulation. All of them are lists, except the arrows, so that RViz has few of them to keep.
#include "deformable_surface/ros/markers.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::node {
namespace {

using visualization_msgs::Marker;

// Full colour scale: strains of cloth and rubber sheets in use lie below it, and half of it is plainly visible.
constexpr double kFullStrain = 0.1;
// Displacements saturate at this share of the surface's extent.
constexpr double kFullDisplacementShare = 0.25;
// Sizes as shares of the spacing: lines thin enough not to hide the surface, balls that do not touch.
constexpr double kLineWidthShare = 0.05, kPinShare = 0.5;
// The longest arrow, as a share of the surface's extent.
constexpr double kArrowShare = 0.3;
// Shaft, head and head length as shares of an arrow's length.
constexpr double kShaftShare = 0.05, kHeadShare = 0.12, kHeadLengthShare = 0.25;

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

/// RViz refuses lists without points: one with nothing to show deletes itself.
Marker finish(Marker marker) {
  if (marker.points.empty()) marker.action = Marker::DELETE;
  return marker;
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

std_msgs::ColorRGBA colorOf(double value) {
  if (std::isnan(value)) return makeColor(0.5f, 0.5f, 0.5f);
  // Four straight pieces in the colour cube: blue, cyan, green, yellow, red.
  const auto ramp = [](double t) { return static_cast<float>(std::min(1.0, std::max(0.0, t))); };
  const double t = 4.0 * value;
  return makeColor(ramp(t - 2.0), std::min(ramp(t), ramp(4.0 - t)), ramp(2.0 - t));
}

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
  Marker marker = makeMarker(header, "surface", 0, Marker::TRIANGLE_LIST);
  marker.points.reserve(3 * triangles.size());
  marker.colors.reserve(3 * triangles.size());
  for (const model::WeightedTriangle& triangle : triangles)
    for (Index corner : triangle.corner) appendCorner(corner, positions, values, full_scale, marker);
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

Marker makePinsMarker(const std_msgs::Header& header, const Points& positions, const std::vector<char>& pinned, double diameter) {
  Marker marker = makeMarker(header, "pins", 0, Marker::SPHERE_LIST);
  marker.scale.x = marker.scale.y = marker.scale.z = diameter;
  marker.color = makeColor(0.8f, 0.1f, 0.6f);
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (pinned[i]) marker.points.push_back(toPoint(positions[i]));
  return finish(std::move(marker));
}

int addForceMarkers(const std_msgs::Header& header, const std::vector<std::pair<Vec3, Vec3>>& forces, double length,
                    int num_before, visualization_msgs::MarkerArray& markers) {
  const int num_shown = static_cast<int>(std::min<std::size_t>(forces.size(), kMaxArrows));
  double largest = 0.0;
  for (int f = 0; f < num_shown; ++f) largest = std::max(largest, forces[f].second.norm());
  for (int f = 0; f < std::max(num_shown, num_before); ++f) {
    Marker marker = makeMarker(header, "forces", f, Marker::ARROW);
    const double share = f < num_shown && largest > 0.0 ? forces[f].second.norm() / largest : 0.0;
    if (share > 0.0) {
      const auto& [point, force] = forces[f];
      marker.points = {toPoint(point), toPoint(point + length / largest * force)};
      marker.scale.x = kShaftShare * length;
      marker.scale.y = kHeadShare * length;
      marker.scale.z = kHeadLengthShare * length * share;
      marker.color = makeColor(1.0f, 0.5f, 0.0f);
    }
    markers.markers.push_back(finish(std::move(marker)));
  }
  return num_shown;
}

SimulationMarkers::SimulationMarkers(const simulation::Simulation& simulation)
    : rest_positions_(simulation.state().positions), edges_(collectEdges(simulation.model().triangles())) {
  Vec3 low = rest_positions_.front(), high = low;
  for (const Vec3& p : rest_positions_) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  extent_ = (high - low).norm();
  // Without any link the extent shared among the points has to do.
  const auto& links = edges_.empty() ? simulation.model().stretchLinks() : edges_;
  for (const auto& [a, b] : links) spacing_ += (rest_positions_[a] - rest_positions_[b]).norm() / links.size();
  if (links.empty()) spacing_ = extent_ / rest_positions_.size();
}

void SimulationMarkers::make(const std_msgs::Header& header, const simulation::Simulation& simulation,
                             visualization_msgs::MarkerArray& markers) {
  const model::State& state = simulation.state();
  const model::DeformableModel& model = simulation.model();
  const Points& positions = state.positions;
  model.computePointStrain(state, strain_);
  displacement_.resize(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) displacement_[i] = (positions[i] - rest_positions_[i]).norm();

  const double width = kLineWidthShare * spacing_;
  markers.markers.clear();
  markers.markers.push_back(
      makeLinksMarker(header, "stretch_springs", positions, model.stretchLinks(), strain_, kFullStrain, width));
  markers.markers.push_back(
      makeLinksMarker(header, "bending_springs", positions, model.bendLinks(), strain_, kFullStrain, width));
  markers.markers.push_back(
      makeSurfaceMarker(header, positions, model.triangles(), displacement_, kFullDisplacementShare * extent_));
  markers.markers.push_back(makeWireframeMarker(header, positions, edges_, width));
  markers.markers.push_back(makePinsMarker(header, positions, simulation.pinned(), kPinShare * spacing_));
  num_arrows_ = addForceMarkers(header, simulation.activeForces(), kArrowShare * extent_, num_arrows_, markers);
}

}  // namespace deformable_surface::node
