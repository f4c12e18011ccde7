// Orders points in memory so that neighbours in space are neighbours in memory, whatever the order of the cloud.
#pragma once

#include "deformable_surface/cloud/clean.h"

namespace deformable_surface::cloud {

/// Sorts the points along a space-filling curve [Morton 1966] if they are many and their order is scattered: for most points
/// the next one is much farther away than a neighbour. Returns whether it sorted. The map from the input's points
/// stays valid.
bool orderInSpace(CleanCloud& cloud);

}  // namespace deformable_surface::cloud
