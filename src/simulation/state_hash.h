// A hash of every bit of a state: different states have different hashes. Snapshots and tests of points
// use it too.
#pragma once

#include "deformable_surface/base/hash.h"
#include "deformable_surface/model/deformable_model.h"

#include <cstdint>
#include <cstring>

namespace deformable_surface::simulation {

inline std::uint64_t hashWords(const double* words, int count, std::uint64_t h) {
  for (int k = 0; k < count; ++k) {
    std::uint64_t bits;
    std::memcpy(&bits, words + k, sizeof bits);
    h = mixHash(h, bits);
  }
  return h;
}

inline std::uint64_t hashPoints(const Points& points, std::uint64_t h = kHashBegin) {
  for (const Vec3& p : points) h = hashWords(p.data(), 3, h);
  return h;
}

inline std::uint64_t hashState(const model::State& state) {
  std::uint64_t h = hashPoints(state.velocities, hashPoints(state.positions));
  for (const Quaternion& q : state.orientations) h = hashWords(q.coeffs().data(), 4, h);
  for (const Mat3& plastic : state.plastic) h = hashWords(plastic.data(), 9, h);
  return hashPoints(state.spins, h);
}

}  // namespace deformable_surface::simulation
