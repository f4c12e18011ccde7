// The median, found without sorting.
#pragma once

#include <algorithm>
#include <vector>

namespace deformable_surface {

/// The upper median if the number of values is even. values: not empty, no NaN. O(n).
inline double findMedian(std::vector<double> values) {
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace deformable_surface
