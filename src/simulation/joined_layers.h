// Layers of a cloud that its neighbourhoods do not tell apart. Private.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

namespace deformable_surface::simulation {

/// Tells how many simulation points are linked, at most over one other, to points that lie above or below them, and where: near
/// layers, and single points between layers, look like that. A warning if they are more than one in four, else a note. s: with
/// simulation points and their rings.
void noteJoinedLayers(RestSurface& s);

}  // namespace deformable_surface::simulation
