// Gaps along jumps in the spacing of points: links are a few spacings long at most, and points of a coarse part are farther from
// those of a fine one. Private.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

namespace deformable_surface::simulation {

/// Warns of points at the edge of a surface that face far denser ones across a gap no wider than their own spacing: how many, and
/// where. Only where all points are simulated. s: with simulation points and their rings.
void warnOfOpenSeams(RestSurface& s);

}  // namespace deformable_surface::simulation
