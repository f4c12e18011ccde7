// RViz markers of a simulation: few markers with many elements each. RViz is slow with many markers, and refuses markers that
// break its rules, or crashes. Every function here returns markers that follow them.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/ros/convert/color_scale.h"
#include "deformable_surface/ros/convert/text_place.h"
#include "deformable_surface/simulation/simulation.h"

#include <std_msgs/Header.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <utility>
#include <vector>

namespace deformable_surface::node {

/// Lines between linked points (LINE_LIST), each end in the colour of value / full_scale. positions (m x 3), values (m).
/// width: of a line, m, > 0. Without links the marker deletes itself; the markers below do the same.
visualization_msgs::Marker makeLinksMarker(const std_msgs::Header& header, const std::string& ns, const Points& positions,
                                           const std::vector<std::pair<Index, Index>>& links, const std::vector<double>& values,
                                           double full_scale, double width);

/// The surface itself (TRIANGLE_LIST), each corner in the colour of value / full_scale, as if lit from above.
visualization_msgs::Marker makeSurfaceMarker(const std_msgs::Header& header, const Points& positions,
                                             const std::vector<model::WeightedTriangle>& triangles,
                                             const std::vector<double>& values, double full_scale);

/// The same with cubic patches instead of the triangles (model/curved_triangles.h), in the light of their own normals.
/// pieces: of an edge, > 1.
visualization_msgs::Marker makePatchesMarker(const std_msgs::Header& header, const Points& positions,
                                             const Orientations& orientations,
                                             const std::vector<model::WeightedTriangle>& triangles,
                                             const std::vector<double>& values, double full_scale, Index pieces);

/// The edges of the triangles (LINE_LIST), all in one colour.
visualization_msgs::Marker makeWireframeMarker(const std_msgs::Header& header, const Points& positions,
                                               const std::vector<std::pair<Index, Index>>& edges, double width);

/// The force at each contact (LINE_LIST) as a line from its place; the largest is length long. touches: place in m, and force.
visualization_msgs::Marker makeContactsMarker(const std_msgs::Header& header, const std::vector<std::pair<Vec3, Vec3>>& touches,
                                              double length, double width);

/// A ball at each pinned point (SPHERE_LIST).
visualization_msgs::Marker makePinsMarker(const std_msgs::Header& header, const Points& positions,
                                          const std::vector<char>& pinned, double diameter);

/// Appends one ARROW per force, from the point of attack along the force, the largest of length `length` (m). Deletes the
/// arrows left over from the `num_before` of last time. At most kMaxArrows, the first ones, are shown. Returns how many.
int addForceMarkers(const std_msgs::Header& header, const std::string& ns, const std_msgs::ColorRGBA& color,
                    const std::vector<std::pair<Vec3, Vec3>>& forces, double length, int num_before,
                    visualization_msgs::MarkerArray& markers);

/// The statistics of the last step, as lines of text (TEXT_VIEW_FACING) above the place.
visualization_msgs::Marker makeStatisticsMarker(const std_msgs::Header& header, const simulation::Statistics& statistics,
                                                const TextPlace& place);

/// Appends the legend of the colours: the name of the quantity, and below it in one row numbers from 0 to full_scale (in the
/// unit), each in its own colour. Both are above the statistics.
void addLegendMarkers(const std_msgs::Header& header, const std::string& ns, const std::string& quantity, const std::string& unit,
                      double full_scale, const TextPlace& place, visualization_msgs::MarkerArray& markers);

/// Appends one marker per tool that acts at the time (s), in the colour of its mode: the primitive, a cone as triangles, a
/// plane as a thin plate of the extent (m, > 0). Deletes those left over from the `num_before` of last time. Returns how many
/// there are.
int addToolMarkers(const std_msgs::Header& header, const std::vector<tool::ToolParams>& tools, double time, double extent,
                   int num_before, visualization_msgs::MarkerArray& markers);

/// Oriented particles as hexagons across their normals (TRIANGLE_LIST), each in the colour of value / full_scale. radius: m, > 0.
visualization_msgs::Marker makeDiscsMarker(const std_msgs::Header& header, const Points& positions,
                                           const Orientations& orientations, const std::vector<double>& values, double full_scale,
                                           double radius);

/// The axes of oriented particles (LINE_LIST): x red, y green, and the normal z blue. length, width: m, > 0.
visualization_msgs::Marker makeAxesMarker(const std_msgs::Header& header, const Points& positions,
                                          const Orientations& orientations, double length, double width);

// RViz draws a few hundred arrows smoothly, thousands of them at a crawl.
constexpr int kMaxArrows = 100;

/// All markers of a simulation: namespaces stretch_springs, bending_springs, surface, wireframe, pins, forces, tools, contacts
/// (the force on each tool, at its origin), statistics, strain_legend, displacement_legend and, for oriented particles, discs and
/// axes. Particles may be added and removed; for displacements, particles that were not there at first have the colour of NaN.
class SimulationMarkers {
 public:
  /// The simulation must be at rest: displacements are measured from its positions now, sizes come from its spacing.
  SimulationMarkers(const simulation::Simulation& simulation, const std::string& frame_id);

  /// Replaces the content of markers by all of them, including deletions, so that each message is complete.
  void make(const std_msgs::Header& header, const simulation::Simulation& simulation, visualization_msgs::MarkerArray& markers);

 private:
  Vec3 findRest(Index id) const;

  Points rest_positions_;                                  // by the particles' ids, else by index; NaN: none
  std::vector<std::pair<Index, Index>> edges_;             // of the triangles, each once
  std::size_t num_triangles_ = 0;                          // number of triangles that the edges were made from
  double spacing_ = 0.0;                                   // m, mean length of an edge or link at rest
  double extent_ = 0.0;                                    // m, diagonal of the main box at rest
  TextPlace text_place_;                                   // above the surface at rest
  int num_arrows_ = 0, num_tools_ = 0, num_contacts_ = 0;  // the most that were shown at a time
  std::vector<double> strain_, displacement_;              // scratch
};

}  // namespace deformable_surface::node
