// A hash of values, the same on every machine.
#pragma once

#include <cstdint>

namespace deformable_surface {

/// The start value, and the hash extended by one byte or word. As FNV-1a, with the high half folded down after each product:
/// alone, products carry differences upwards only, and two numbers of the other sign would cancel.
constexpr std::uint64_t kHashBegin = 14695981039346656037ull;
constexpr std::uint64_t mixHash(std::uint64_t hash, std::uint64_t value) {
  const std::uint64_t product = (hash ^ value) * 1099511628211ull;
  return product ^ (product >> 32);
}

}  // namespace deformable_surface
