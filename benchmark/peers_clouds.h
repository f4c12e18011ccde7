// Neighbours and normals of other programs beside ours. Apart from the other peers, because these take a cloud and no scene.
#pragma once

#include "sections.h"

namespace deformable_surface::benchmark {

/// The neighbours of every point: nanoflann, FLANN.
void compareNeighbors(const Options& options, Report& report);

/// Normals from neighbours: PCL.
void compareNormals(const Options& options, Report& report);

}  // namespace deformable_surface::benchmark
