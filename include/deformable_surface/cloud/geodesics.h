// Distances along the surface: shortest paths over a graph of the points in which jumps through space are expensive. Rings,
// simplification, transfer and models that weigh links use it: points that are near in space need not belong together.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/types.h"

#include <limits>

namespace deformable_surface::cloud {

/// Normals that complement the positions. None (empty): the gap between two parts must be wider than the spacing. Normals without
/// a common side: parallel sheets are separated. Oriented normals: the two sides of a thin body are separated, too.
struct SurfaceSides {
  Points normals;          // (n x 3) unit, or empty
  bool oriented = false;   // their signs count: each points to the same side as its neighbours on the surface
  Points at_creases = {};  // (n x 3) unit, or empty: other normals, those of one side of a crease; the better ones count
};

/// Paths run along its links; a path is chosen by the least sum of costs.
///   geodesic_exponent auto: cost l [1 + 18 max(0, (l / r)^2 - 1)] (m) of a link of length l, where r is the larger trust radius
///   of
///     its ends: the length that holds the surface together around a point, from the links of the minimum spanning tree and, with
///     normals, from how points are surrounded (src/cloud/trust_radii.h). A trusted link costs its length, longer ones ever more.
///     Lengths are anisotropic where there are normals, l^2 = t^2 + (m / e)^2 with the component m of the link along the mean
///     normal of its ends, t across: a step from sheet to sheet is long, a step around a bend is not. Where the tangent planes of
///     its ends meet, it is at most as long as the way over the line in which they do: a crease. The distance of two points is
///     the cost of their path (m).
///   a number gamma >= 1: cost (l / s)^gamma, with the median length s of the shortest links; the published weight
///     |x_i - x_j|^gamma up to a common factor, so that neither units nor small lengths matter. The distance of two points is the
///     Euclidean length of their path (m).
struct GeodesicGraph {
  Lists links;                       // (n) symmetric
  std::vector<double> cost;          // of each link, as listed
  bool cost_is_distance = false;     // else the distance is the Euclidean length of the path
  std::vector<double> trust_radius;  // (n) m; empty with a given exponent
  bool is_directional = false;       // of a body that is sampled more densely in one direction
};

/// neighbors: of every point, nearest first; a pair is linked if either lists the other. Links that no chosen path can use
/// within the reach of the lists are omitted. min_gap: m, for geodesic_exponent auto: links up to this length in space are
/// trusted. of_body: the points fill a body, which may be sampled up to twice as densely in one direction as in another. Throws
/// InputError if sizes do not fit or geodesic_exponent is below 1. Parallel; O(n k log n).
GeodesicGraph buildGeodesicGraph(const Points& positions, const SurfaceSides& sides, const Lists& neighbors,
                                 const OrAuto<double>& geodesic_exponent, double min_gap = 0.0, bool of_body = false);

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// Distance (m) of every pair in links, as listed; infinite where there is no path. The search around a point ends at the
/// first point, in the order of cost, whose distance is more than max_detour times the point's longest pair. Points not reached
/// by then count as infinitely far: a cheaper path would leave the neighbourhood. Parallel; O(points met, for each point).
std::vector<double> findGeodesicDistances(const GeodesicGraph& graph, const Points& positions, const Lists& links,
                                          double max_detour = kNoLimit);

/// Weight in [0, 1] of a link by its detour, geodesic over Euclidean distance: 1 up to kFreeDetour, 0 from kLongestDetour on,
/// smooth and decreasing between. Coincident points have detour 1.
double weighDetour(double detour);
constexpr double kFreeDetour = 1.7;     // above the way around half of a circle, as around a hole of the sampling
constexpr double kLongestDetour = 4.5;  // well above those of rough and unevenly sampled surfaces (docs/geodesics.md)
/// Detour at which the weight is a half. Points with a longer detour are no neighbours.
constexpr double kKeptDetour = 0.5 * (kFreeDetour + kLongestDetour);
/// The same limit for paths over listed neighbours with their lengths in space. The lists do not lead across gaps, so
/// that the length of a path around a gap alone shows it.
constexpr double kKeptWay = 2.0;

/// Weight of every pair in links, as listed: for models that weigh their links. Parallel; O(n k log k).
std::vector<double> geodesicWeights(const GeodesicGraph& graph, const Points& positions, const Lists& links);

/// Neighbours along the surface, and how clearly they are separated from other points.
struct GeodesicNeighbors {
  Lists lists;                   // (n) nearest first, by Euclidean distance; as many as before if the surface has as many
  std::vector<char> is_changed;  // (n) false: the list is as it was
  Index num_refused = 0;         // listed pairs that are close in space only
  Index num_at_gaps = 0;         // points at gaps that see the other side themselves
  /// Length over trust radius of the nearest neighbour there, at the twentieth such point, shortest first. At 1 the
  /// narrowest gap would be bridged. Infinite where there are no such points, and with a given exponent.
  double margin = kNoLimit;
  /// Points opposite another, with oriented normals that face each other, that are near along the surface only by links from
  /// one side to the other: parts that stick together across a gap too narrow for the sampling. 0 with a given exponent.
  Index num_joined = 0;
};

/// At gaps, removes neighbours of less than half the weight from the lists (nearest first), and adds the next points along the
/// surface. A point is at a gap if at least three of it and its nearest see neighbours one and a half times as far along the
/// surface. Single holes of a sampling are no gap. All other lists stay as they are. Parallel; O(n k).
GeodesicNeighbors keepGeodesicNeighbors(const GeodesicGraph& graph, const Points& positions, const SurfaceSides& sides,
                                        Lists neighbors);

/// For every point, its nearest points in space, as many as it has neighbours along the surface, that are neighbours in neither
/// of the two lists. Symmetric, ascending. For models that look for neighbours in space themselves.
/// O(n (log n + k log k)).
Lists findRefusedPairs(const Points& positions, const Lists& over_surface);

}  // namespace deformable_surface::cloud
