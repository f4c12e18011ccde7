// Chooses the points between simulation points that touch tools or carry forces with a radius: points of the cloud, or, where all
// of these are simulated, places on triangles. The rest surface is built without them if there are no tools and no such forces;
// coarser copies always have them.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include <memory>

namespace deformable_surface::simulation {

/// At most params.contact.cloud_points in the cell of each simulation point (the points nearest to it over the surface), spread
/// over the cell: each is the farthest from those before it and from the simulation point. With spare ones, the next farthest
/// follow, up to kMostPoints in all, where the cloud shows the simulation point, which sharp bends leave, and in cells of few
/// points places on the triangles. dense: the cloud from which the surface was built. Null if there are none.
std::shared_ptr<const transfer::SampledPoints> choosePointsBetween(const SceneParams& params, const cloud::CleanCloud& dense,
                                                                   const RestSurface& surface, bool with_spare);
constexpr Index kMostPoints = 32;  // of a cell: a sixth of the spacing apart

/// For a surface of which every point is simulated: places on the flat triangles between its points, a quarter of a side apart.
/// All are spare. Null if params.contact.cloud_points is 0.
std::shared_ptr<const transfer::SampledPoints> choosePlacesOnTriangles(const SceneParams& params, const RestSurface& surface);
/// The same on given triangles, as around a body. rest: (n x 3) m, of their corners.
std::shared_ptr<const transfer::SampledPoints> choosePlacesOnTriangles(const SceneParams& params,
                                                                       const std::vector<model::WeightedTriangle>& triangles,
                                                                       const Points& rest);

/// Points in a cell at most: they resolve the edge of a loaded patch to about a sixth of the spacing.
constexpr Index kMostLoadPoints = 32;
/// The same for coarser copies, whose points are chosen before it is known whether there will be forces: those that touch tools.
constexpr Index kMostLoadPointsOfCopies = 8;

/// The points that carry forces with a radius: at most `most` in a cell, spread as above. Each stands for the points of the cloud
/// in its cell that are nearest to it. between: the choice of choosePointsBetween() without spare points, which is used again if
/// it has as many; or null. Null if there are none.
std::shared_ptr<const LoadPoints> chooseLoadPoints(const SceneParams& params, const cloud::CleanCloud& dense,
                                                   const RestSurface& surface, Index most,
                                                   std::shared_ptr<const transfer::SampledPoints> between = nullptr);

/// Marks (1) the points that follow simulation points on both sides of a cut: some of these are no longer within a few links of
/// the cell's point, or corners of the triangle are no longer linked. links: whole links of the m simulation points.
std::vector<char> findSevered(const transfer::SampledPoints& between, const std::vector<std::pair<Index, Index>>& links, Index m);

}  // namespace deformable_surface::simulation
