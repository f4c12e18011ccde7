// Which points of the whole surface a part of it has. Its own file, because each kind of element makes its part from it.
#pragma once

#include "deformable_surface/base/types.h"

#include <algorithm>

namespace deformable_surface::model {

struct PartIndex {
  std::vector<Index> wanted;     // ascending: all their elements are in the part
  std::vector<Index> points;     // ascending: those and all others of these elements
  std::vector<Index> new_index;  // (of the whole) -1: not in the part

  Index size() const { return static_cast<Index>(points.size()); }
};

/// The elements at some points, each once and ascending. find(k): the element that the k-th item of a point's list belongs to;
/// stride: items of an element and point.
template <class Find>
std::vector<Index> findElements(const std::vector<Index>& points, const Lists& items, Index stride, Find&& find) {
  std::vector<Index> elements;
  for (const Index i : points)
    for (Index k = items.offsets[i]; k < items.offsets[i + 1]; k += stride) elements.push_back(find(k));
  std::sort(elements.begin(), elements.end());
  elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
  return elements;
}

}  // namespace deformable_surface::model
