// Points that loads and grips hold, after the population has changed.
#pragma once

#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface::simulation {

/// points take new indices: new_index of the former ones, -1 = removed. values: one of each point; those that remain keep it.
template <class Values>
void renumberPoints(const std::vector<Index>& new_index, std::vector<Index>& points, Values& values) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (new_index[points[k]] < 0) continue;
    points[kept] = new_index[points[k]];
    values[kept++] = values[k];
  }
  points.resize(kept);
  values.resize(kept);
}

}  // namespace deformable_surface::simulation
