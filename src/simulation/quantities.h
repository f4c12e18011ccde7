// What the final cloud shows and `expect` may bound, beside the numbers of Statistics: one table of names and of what they need.
// Private.
#pragma once

#include "deformable_surface/base/types.h"

#include <string>
#include <vector>

namespace deformable_surface::simulation {

struct Quantity {
  const char* name;
  bool needs_particles = false;
  Index least_points = 1;  // simulation points without which there is none
};

/// In the order in which pages list them.
const std::vector<Quantity>& quantities();
/// Null if no quantity has this name.
const Quantity* findQuantity(const std::string& name);

}  // namespace deformable_surface::simulation
