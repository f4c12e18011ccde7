// Requirements of a scene for its simulation points before anything moves: dense points to keep, because loads act
// there, and places with a smaller spacing than the average: edges of small pins that clamp, and points
// of forces without a radius, around which a plate's curvature grows without bound. Simplification knows no
// scene. Private.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

namespace deformable_surface::simulation {

/// Bounds of the wanted spacings, over the mean, and their growth per distance (both over the mean spacing): a star of
/// neighbours then sees about the same spacing on all sides.
constexpr double kFinestWanted = 0.4, kCoarsestWanted = 2.5, kWantedGrowth = 0.3;

/// The wanted spacing of the simulation points around each dense point, over the mean (n): the area integral of 1 / h^2
/// is the area, so that as many points are needed as with one spacing everywhere. It is least at the edges of small pins that
/// clamp, at the points of forces without a radius, and at anchors. It grows with the distance along the surface from there;
/// inside a pin, where nothing bends, faster. Empty if there is nothing of the kind. target: the number of points wanted.
/// Lipschitz: |h_i - h_j| <= kWantedGrowth d / mean spacing for neighbours i, j at the distance d, except inside pins.
/// Uses the dense points of s, their normals, neighbours and area. O(n k log n).
std::vector<double> findWantedSpacing(const SceneParams& params, const std::vector<char>& is_boundary, Index target,
                                      const RestSurface& s);

/// The points at which forces without a radius and anchors act.
Points findLoadedPlaces(const SceneParams& params);

/// The dense points at which forces without a radius and anchors act, ascending. They stay simulation points, so that these
/// loads act where they were put. A force that starts later takes the nearest point at that time. O(n log n) if there is any.
std::vector<Index> chooseLoadedPoints(const SceneParams& params, const Points& dense);

/// The area that the dense points sample, m^2, from the discs that hold their k neighbours. It needs no normals and is accurate
/// to a few per cent.
double estimateArea(const RestSurface& s, Index k, const std::vector<char>& is_boundary);

}  // namespace deformable_surface::simulation
