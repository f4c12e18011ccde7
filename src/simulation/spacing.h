// The mean spacing of points on a surface, as everything below simulation/ measures lengths.
#pragma once

#include <cmath>

namespace deformable_surface::simulation {

/// m: the edge of the square that each point has of the area, m^2. Hexagonal lattices of the same density have 1.07 times this
/// distance between neighbours.
template <class Count>
double findSpacing(double area, Count num_points) {
  return std::sqrt(area / static_cast<double>(num_points));
}

}  // namespace deformable_surface::simulation
