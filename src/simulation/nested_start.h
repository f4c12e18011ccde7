// Start of the search for a first equilibrium: the equilibrium of fewer points, found in a fraction of the time. The
// solver knows no coarser surfaces.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include <atomic>

namespace deformable_surface::simulation {

/// Solves the static scene from rest on a sixteenth of the points of `level`. If that took Newton's method, it continues there
/// on a quarter. Moves the points of `level` with the result: (n x 3) m, pinned ones at rest. If several equilibria exist, this
/// chooses the one that the coarser surface finds. Empty if there are too few points, `level` has no order of removal, a
/// coarser surface finds no equilibrium, or interrupt (see Simulation::setInterrupt()) has ended the search.
Points findNestedStart(const SceneParams& params, const RestSurface& level, const std::atomic<bool>* interrupt);

}  // namespace deformable_surface::simulation
