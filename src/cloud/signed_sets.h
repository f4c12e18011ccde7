// Disjoint sets whose members know on which side of each other they are. Several threads may join them at once. For the
// orientation of normals.
#pragma once

#include "deformable_surface/base/types.h"

#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

namespace deformable_surface::cloud {

/// The root of a set is its smallest index, whatever the order of the joins. [Anderson and Woll 1991, wait-free union-find]
class SignedSets {
 public:
  explicit SignedSets(Index n) : parent_(n) { reset(); }

  /// Puts every point in a set of its own.
  void reset() {
    Index i = 0;
    for (std::atomic<std::uint32_t>& parent : parent_) parent.store(pack(i++, false), std::memory_order_relaxed);
  }

  /// The root of i.
  Index find(Index i) { return indexOf(locate(i)); }
  /// Whether i and j, of one set, are on opposite sides.
  bool areOpposite(Index i, Index j) { return isOpposite(locate(i) ^ locate(j)); }

  /// Joins the sets of i and j so that they are on opposite sides or not; no effect within a set.
  void join(Index i, Index j, bool are_opposite) {
    for (;;) {
      std::uint32_t a = locate(i), b = locate(j);
      if (indexOf(a) == indexOf(b)) return;
      if (indexOf(a) < indexOf(b)) std::swap(a, b);
      std::uint32_t as_root = pack(indexOf(a), false);
      if (parent_[indexOf(a)].compare_exchange_strong(as_root, pack(indexOf(b), isOpposite(a ^ b) != are_opposite))) return;
    }
  }

 private:
  // A point, and whether another is on the opposite side of it.
  static std::uint32_t pack(Index i, bool is_opposite) { return static_cast<std::uint32_t>(i) << 1 | (is_opposite ? 1u : 0u); }
  static Index indexOf(std::uint32_t packed) { return static_cast<Index>(packed >> 1); }
  static bool isOpposite(std::uint32_t packed) { return (packed & 1u) != 0; }

  // The root of i, and whether i is on the opposite side of it. Paths are shortened to any ancestor: each of them is
  // correct.
  std::uint32_t locate(Index i) {
    std::uint32_t side = 0;
    for (;;) {
      const std::uint32_t up = parent_[i].load(std::memory_order_relaxed);
      if (indexOf(up) == i) return pack(i, side != 0);
      const std::uint32_t farther = parent_[indexOf(up)].load(std::memory_order_relaxed);
      if (indexOf(farther) != indexOf(up)) parent_[i].store(farther ^ (up & 1u), std::memory_order_relaxed);
      side ^= up & 1u;
      i = indexOf(up);
    }
  }

  std::vector<std::atomic<std::uint32_t>> parent_;
};

}  // namespace deformable_surface::cloud
