// Which points of the whole surface belong to a part. Each kind of element makes its part from it.
#pragma once

#include "deformable_surface/base/types.h"

#include <algorithm>
#include <limits>

namespace deformable_surface::model {

struct PartIndex {
  std::vector<Index> wanted;     // ascending: all their elements are in the part
  std::vector<Index> points;     // ascending: the wanted points and all others of their elements
  std::vector<Index> new_index;  // (of the whole) -1: not in the part

  Index size() const { return static_cast<Index>(points.size()); }
};

/// The elements at some points, each once and ascending. find(k): the element that the k-th item of a point's list belongs to;
/// stride: items of an element and point.
template <class Find>
std::vector<Index> findElements(const std::vector<Index>& points, const Lists& items, Index stride, Find&& find) {
  // Marks, which need no sorting. The thread keeps them; they are clear between calls.
  static thread_local std::vector<char> is_found;
  Index first = std::numeric_limits<Index>::max(), last = -1, count = 0;
  for (const Index i : points) {
    for (Index k = items.offsets[i]; k < items.offsets[i + 1]; k += stride) {
      const Index element = find(k);
      if (static_cast<std::size_t>(element) >= is_found.size()) is_found.resize(2 * static_cast<std::size_t>(element) + 1);
      count += !is_found[element];
      is_found[element] = 1;
      first = std::min(first, element);
      last = std::max(last, element);
    }
  }
  std::vector<Index> elements;
  elements.reserve(count);
  for (Index element = first; element <= last; ++element) {
    if (!is_found[element]) continue;
    elements.push_back(element);
    is_found[element] = 0;
  }
  return elements;
}

}  // namespace deformable_surface::model
