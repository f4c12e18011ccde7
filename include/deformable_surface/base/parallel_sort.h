// Sorting on all cores. Few files need it, while parallel.h is included everywhere.
#pragma once

#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace deformable_surface {

/// Sorts by <, which must be a strict total order. Needs twice the memory while it runs.
template <class T>
void parallelSort(std::vector<T>& values) {
  const std::size_t n = values.size();
  std::size_t run = std::size_t{1} << 14;  // sorted at once: about a millisecond of work
  const auto forPairs = [&](std::size_t length, const auto& body) {
    const Index num = static_cast<Index>((n + length - 1) / length);
    parallelFor(num, 1, [&](Index k, Index) { body(k * length, std::min(n, (k + 1) * length)); });
  };
  forPairs(run, [&](std::size_t begin, std::size_t end) { std::sort(values.begin() + begin, values.begin() + end); });
  for (std::vector<T> merged(run < n ? n : 0); run < n; run *= 2) {
    forPairs(2 * run, [&](std::size_t begin, std::size_t end) {
      const auto middle = values.begin() + std::min(end, begin + run);
      std::merge(values.begin() + begin, middle, middle, values.begin() + end, merged.begin() + begin);
    });
    values.swap(merged);
  }
}

}  // namespace deformable_surface
