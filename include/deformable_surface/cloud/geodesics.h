// Distances that stay on the surface: shortest paths over a graph of the points in which jumps through space are dear. Rings,
// simplification, transfer and models that weigh links ask here what merely is close in space and what belongs together.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/types.h"

#include <limits>

namespace deformable_surface::cloud {

/// What normals say beside positions. None (empty): the gap between two parts must be wider than the spacing. Normals without
/// a common side: parallel sheets are told apart. Oriented ones: the two sides of a thin body as well.
struct SurfaceSides {
  Points normals;         // (n x 3) unit, or empty
  bool oriented = false;  // their signs count: each points to the same side as its neighbours on the surface
};

/// Paths run along its links; a path is chosen by the least sum of costs.
///   geodesic_exponent auto: cost l [1 + 18 max(0, (l / r)^2 - 1)] (m) of a link of length l, where r is the larger trust radius
///   of
///     its ends: what it takes around a point to hold the surface together, by the links of the minimum spanning tree and, with
///     normals, by how points are surrounded (src/cloud/trust_radii.h). A trusted link costs its length, a longer one ever more.
///     Lengths are anisotropic where there are normals, l^2 = t^2 + (m / e)^2 with the component m of the link along the mean
///     normal of its ends, t across: a step from sheet to sheet is long, one around a bend or a crease is not. The distance of
///     two points is the cost of their path (m).
///   a number gamma >= 1: cost (l / s)^gamma, with the median length s of the shortest links; the published weight
///     |x_i - x_j|^gamma up to a common factor, so that neither units nor small lengths matter. The distance of two points is the
///     Euclidean length of their path (m).
struct GeodesicGraph {
  Lists links;                       // (n) symmetric
  std::vector<double> cost;          // of each link, as listed
  bool cost_is_distance = false;     // else the distance is the Euclidean length of the path
  std::vector<double> trust_radius;  // (n) m; empty with a given exponent
};

/// neighbors: of every point, nearest first; a pair is linked if either lists the other. Links that no chosen path can use
/// within the reach of the lists are left out. min_gap: m, of geodesic_exponent auto: links no longer than that in space are
/// trusted. Throws InputError if sizes do not fit or geodesic_exponent is below 1. Parallel; O(n k log n).
GeodesicGraph buildGeodesicGraph(const Points& positions, const SurfaceSides& sides, const Lists& neighbors,
                                 const OrAuto<double>& geodesic_exponent, double min_gap = 0.0);

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// Distance (m) of every pair in links, as listed; infinite where there is no path. The search around a point ends with the
/// first point, in the order of cost, whose distance is more than max_detour times the point's longest pair: what it has not met
/// by then counts as infinitely far, for a cheaper way leaves the neighbourhood. Parallel; O(points met, for each point).
std::vector<double> findGeodesicDistances(const GeodesicGraph& graph, const Points& positions, const Lists& links,
                                          double max_detour = kNoLimit);

/// Weight in [0, 1] of a link by its detour, geodesic over Euclidean distance: 1 up to kFreeDetour, 0 from kLongestDetour on,
/// smooth and falling between. Coincident points have detour 1.
double weighDetour(double detour);
constexpr double kFreeDetour = 1.7;     // above the way around half of a circle, as around a hole of the sampling
constexpr double kLongestDetour = 4.5;  // well above those of rough and unevenly sampled surfaces (docs/geodesics.md)
/// Detour at which the weight is a half: who is farther is no neighbour.
constexpr double kKeptDetour = 0.5 * (kFreeDetour + kLongestDetour);
/// The same of ways over listed neighbours that count as long as they are in space: gaps are no dearer there, for the lists do
/// not lead across them, so that a way round shows in its length alone.
constexpr double kKeptWay = 2.0;

/// Weight of every pair in links, as listed: for models that weigh their links. Parallel; O(n k log k).
std::vector<double> geodesicWeights(const GeodesicGraph& graph, const Points& positions, const Lists& links);

/// Neighbours over the surface, and how clearly others could be told from them.
struct GeodesicNeighbors {
  Lists lists;            // (n) nearest first, by Euclidean distance; as many as before where the surface has them
  Index num_refused = 0;  // listed pairs that are close in space only
  Index num_at_gaps = 0;  // points at gaps that see the other side themselves
  /// Length over trust radius of their nearest neighbour there, at the twentieth of them, shortest first: how far the narrowest
  /// gap is from what one would bridge, at 1. Infinite where there are no such points, and with a given exponent.
  double margin = kNoLimit;
  /// Points with one in front of them, whose oriented normal faces theirs, that are near over the surface only by links from one
  /// side to the other: what sticks together across a gap that is too narrow for the sampling. 0 with a given exponent.
  Index num_joined = 0;
};

/// At gaps, takes out of the lists (nearest first) what has less than half the weight, and fills up with the next points over the
/// surface. A point is at a gap if at least three of it and its nearest see neighbours one and a half times as far as that:
/// single holes of a sampling are no gap, and all other lists stay as they are. Parallel; O(n k).
GeodesicNeighbors keepGeodesicNeighbors(const GeodesicGraph& graph, const Points& positions, const SurfaceSides& sides,
                                        Lists neighbors);

/// Of every point those that are its nearest in space, as many as it has neighbours over the surface, but neighbours in neither
/// of the two lists; either way round, ascending. For models that look for neighbours in space themselves.
/// O(n (log n + k log k)).
Lists findRefusedPairs(const Points& positions, const Lists& over_surface);

}  // namespace deformable_surface::cloud
