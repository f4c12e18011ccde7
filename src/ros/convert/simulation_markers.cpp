// All markers of a simulation: sizes, scales and the order of the namespaces.
#include "deformable_surface/ros/convert/markers.h"

#include <algorithm>
#include <limits>

namespace deformable_surface::node {
namespace {

// Full colour scale: strains of cloth and rubber sheets in use are below it, and half of it is clearly visible.
constexpr double kFullStrain = 0.1;
// Displacements saturate at this share of the surface's extent.
constexpr double kFullDisplacementShare = 0.25;
// Sizes as shares of the spacing: lines thin enough not to hide the surface, balls that do not touch.
constexpr double kLineWidthShare = 0.05, kPinShare = 0.5;
// Discs that nearly touch, and axes that do not reach the next particle.
constexpr double kDiscShare = 0.45, kAxisShare = 0.4, kContactShare = 2.0;
// The longest arrow, as a share of the surface's extent.
constexpr double kArrowShare = 0.3;

const Vec3 kNowhere = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());

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

SimulationMarkers::SimulationMarkers(const simulation::Simulation& simulation, const std::string& frame_id) {
  const model::State& state = simulation.state();
  if (const model::Links* drawn = simulation.model().links()) drawn->refreshDisplay(state);
  edges_ = collectEdges(trianglesOf(simulation.model()));
  if (state.positions.empty()) return;  // all particles are gone
  const Box box = findMainBox(state.positions);
  extent_ = box.extent();
  text_place_ = placeText(box, frame_id);
  // Without links the extent is divided by the number of points.
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
  // Triangles change with particles, and are removed where a surface is cut.
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
  const double full = kFullDisplacementShare * extent_;
  const Index pieces = simulation.params().output.pieces_per_edge;
  markers.markers.push_back(
      pieces > 1 ? makePatchesMarker(header, positions, state.orientations, trianglesOf(model), displacement_, full, pieces)
                 : makeSurfaceMarker(header, positions, trianglesOf(model), displacement_, full));
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
  // A reader that starts in the middle of a bag, or lost a message, needs all deletions.
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
  addLegendMarkers(header, "displacement_legend", "displacement", "mm", 1000.0 * full, text_place_, markers);
  markers.markers.push_back(makeStatisticsMarker(header, simulation.statistics(), text_place_));
}

}  // namespace deformable_surface::node
