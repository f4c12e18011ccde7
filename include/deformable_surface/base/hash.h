// A hash of values, the same on every machine.
#pragma once

#include <cstdint>

namespace deformable_surface {

/// FNV-1a: the start value, and the hash extended by one value. The value is a byte, or a whole word where speed matters more
/// than agreement with other programs.
constexpr std::uint64_t kHashBegin = 14695981039346656037ull;
constexpr std::uint64_t mixHash(std::uint64_t hash, std::uint64_t value) { return (hash ^ value) * 1099511628211ull; }

}  // namespace deformable_surface
