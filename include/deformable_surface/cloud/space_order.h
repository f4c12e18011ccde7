// The order in which points lie in memory: neighbours in space are neighbours there, however the cloud was put together.
#pragma once

#include "deformable_surface/cloud/clean.h"

namespace deformable_surface::cloud {

/// Sorts the points along a curve that fills space [Morton 1966] if they are many and the order they have jumps about in it: from
/// most of them to the next one it is much farther than to a neighbour. Returns whether it did. The input's points find theirs as
/// before.
bool orderInSpace(CleanCloud& cloud);

}  // namespace deformable_surface::cloud
