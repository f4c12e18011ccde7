// Where the search for a first equilibrium begins: at that of fewer points, which is found in a fraction of the time. A file of
// its own because it is neither part of a step nor of the solver, which knows no coarser surfaces.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include <atomic>

namespace deformable_surface::simulation {

/// Solves the static scene from rest on a sixteenth of the points of `level`, then, where that took Newton's method, from there
/// on a quarter, and moves the points of `level` with these: (n x 3) m, pinned ones at rest. Where several equilibria exist this
/// chooses the one that the coarser surface finds. Empty if there are too few points, `level` holds no order of removal, a
/// coarser surface finds no equilibrium, or interrupt (see Simulation::setInterrupt()) has ended the search.
Points findNestedStart(const SceneParams& params, const RestSurface& level, const std::atomic<bool>* interrupt);

}  // namespace deformable_surface::simulation
