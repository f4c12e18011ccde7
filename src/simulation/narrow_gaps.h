// Parts that would be one surface but for narrow gaps in it: rows that a sensor left out look like that, and so do slits.
// Private.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

namespace deformable_surface::simulation {

/// Warns of three parts or more between which gaps of a few spacings run along the surface, and notes two: how many there are,
/// how wide the gaps, and what joins them. s: with simulation points, their rings and cells.
void noteNarrowGaps(RestSurface& s);

}  // namespace deformable_surface::simulation
