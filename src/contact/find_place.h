// Where a key is in a sorted list, or would be, from a guess.
#pragma once

#include "deformable_surface/base/types.h"

#include <algorithm>
#include <vector>

namespace deformable_surface::contact {

/// The first of the items, ascending, that is not before the key: isBefore(item, key). As std::lower_bound(), whatever the guess
/// is, but compares the fewer items the nearer it is.
template <class Item, class Key, class IsBefore>
Index findPlace(const std::vector<Item>& items, const Key& key, Index guess, const IsBefore& isBefore) {
  const Index num = static_cast<Index>(items.size());
  Index from = std::min(guess, num), to = from;
  for (Index step = 1; from > 0 && !isBefore(items[from - 1], key); step *= 2) {
    to = from - 1;
    from -= std::min(step, from);
  }
  for (Index step = 1; to < num && isBefore(items[to], key); step *= 2) {
    from = to + 1;
    to += std::min(step, num - to);
  }
  return static_cast<Index>(std::lower_bound(items.begin() + from, items.begin() + to, key, isBefore) - items.begin());
}

}  // namespace deformable_surface::contact
