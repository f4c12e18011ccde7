// Chooses the points of a cloud, between its simulation points, that touch tools. The rest surface is built without them if there
// are no tools.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include <memory>

namespace deformable_surface::simulation {

/// At most params.contact.cloud_points in the cell of each simulation point (the points nearest to it over the surface), spread
/// over the cell: each is the farthest from those before it and from the simulation point. dense: the cloud from which the
/// surface was built. Null if there are none.
std::shared_ptr<const transfer::SampledPoints> choosePointsBetween(const SceneParams& params, const cloud::CleanCloud& dense,
                                                                   const RestSurface& surface);

/// Marks (1) the points that follow simulation points on both sides of a cut: some of these are no longer within a few links of
/// the cell's point. links: whole links of the m simulation points.
std::vector<char> findSevered(const transfer::SampledPoints& between, const std::vector<std::pair<Index, Index>>& links, Index m);

}  // namespace deformable_surface::simulation
