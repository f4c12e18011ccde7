// Numbers for the few points that one search meets. Several searches use it: a table for all points of a cloud would have to
// be cleared for each search.
#pragma once

#include "deformable_surface/base/types.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace deformable_surface::cloud {

/// Numbers the added points from 0 on, in their order.
class PointMap {
 public:
  PointMap() : table_(kSmallest) {}

  void clear() {
    std::fill(table_.begin(), table_.end(), Place{});
    size_ = 0;
  }

  /// The number of the point, or -1.
  Index find(Index point) const { return table_[findPlace(point)].number; }

  /// Adds a point that has no number yet; returns its number.
  Index add(Index point) {
    if (2 * static_cast<std::size_t>(size_ + 1) > table_.size()) grow();
    table_[findPlace(point)] = {point, size_};
    return size_++;
  }

 private:
  static constexpr Index kNone = -1;
  static constexpr std::size_t kSmallest = 256;
  struct Place {
    Index point = kNone, number = kNone;
  };

  std::size_t findPlace(Index point) const {
    std::size_t place = static_cast<std::uint32_t>(point) * 2654435769u >> 7;  // Fibonacci hashing
    for (place &= table_.size() - 1; table_[place].point != kNone && table_[place].point != point;) {
      place = (place + 1) & (table_.size() - 1);
    }
    return place;
  }

  void grow() {
    std::vector<Place> before(2 * table_.size());
    before.swap(table_);
    for (const Place& place : before) {
      if (place.point != kNone) table_[findPlace(place.point)] = place;
    }
  }

  std::vector<Place> table_;  // a power of two
  Index size_ = 0;
};

}  // namespace deformable_surface::cloud
