// Pseudo-random numbers that are the same on every machine and in every run, for starts of iterations and small
// disturbances; not for statistics.
#pragma once

#include <cstdint>

namespace deformable_surface {

constexpr std::uint32_t kRandomSeed = 12345u;

/// The next number of the linear congruential generator of Numerical Recipes; it is also the new seed. Low bits repeat soon.
constexpr std::uint32_t nextRandom(std::uint32_t& seed) { return seed = seed * 1664525u + 1013904223u; }

}  // namespace deformable_surface
