// What a scene wants of its simulation points before anything moves: which dense points are to be among them, since loads act
// there, and where they are to be nearer to each other than on the average: at the edges of small pins that clamp and where
// forces act on a point, about which a plate's curvature grows without a bound. Apart from simplification, which knows no
// scene. Private.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

namespace deformable_surface::simulation {

/// Bounds of the spacings wanted, over the mean, and by how much of a spacing of that mean they grow on the way of one: a star of
/// neighbours sees about the same spacing on all sides.
constexpr double kFinestWanted = 0.4, kCoarsestWanted = 2.5, kWantedGrowth = 0.3;

/// The spacing of the simulation points that is wanted around each dense point, over the mean (n): the area integral of 1 / h^2
/// is the area, so that as many points are needed as with one spacing everywhere. It is least at the edges of small pins that
/// clamp and at the points of forces without a radius, and of anchors, and grows with the distance over the surface from there;
/// inside a pin, where nothing bends, faster. Empty if there is nothing of the kind. target: how many points will be asked for.
/// Lipschitz: |h_i - h_j| <= kWantedGrowth d / mean spacing for neighbours i, j at the distance d, but inside pins.
/// From s it takes the dense points, their normals, neighbours and area. O(n k log n).
std::vector<double> findWantedSpacing(const SceneParams& params, const std::vector<char>& is_boundary, Index target,
                                      const RestSurface& s);

/// The dense points at which forces without a radius and anchors act, ascending: kept as simulation points, so that these loads
/// act where they were put. A force that starts later takes the point that is nearest then. O(n log n) if there is any.
std::vector<Index> chooseLoadedPoints(const SceneParams& params, const Points& dense);

/// The area that the dense points sample, m^2, from the discs that hold their k neighbours: known before normals are trusted, and
/// good to some per cent.
double estimateArea(const RestSurface& s, Index k, const std::vector<char>& is_boundary);

}  // namespace deformable_surface::simulation
