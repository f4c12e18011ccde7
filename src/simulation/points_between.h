// Which points of a cloud, between its simulation points, touch tools. Apart from contact, which sees these points alone, and
// from the rest surface, which is built without them where no tool ever comes.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include <memory>

namespace deformable_surface::simulation {

/// At most so many in the cell of each simulation point (the points nearest to it over the surface), spread over the cell: each
/// is the farthest from those before it and from the simulation point. dense: the cloud of which the points of the surface are.
/// Null if there are none.
std::shared_ptr<const transfer::SampledPoints> choosePointsBetween(const SceneParams& params, const cloud::CleanCloud& dense,
                                                                   const RestSurface& surface);

/// Those that follow simulation points on both sides of a cut (1): some are no longer within a few links of the cell's. links: of
/// m simulation points, that are whole.
std::vector<char> findSevered(const transfer::SampledPoints& between, const std::vector<std::pair<Index, Index>>& links, Index m);

}  // namespace deformable_surface::simulation
