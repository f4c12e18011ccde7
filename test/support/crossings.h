// Whether triangles cut through each other, by signs that rounding does not change. It shares no code with the tested code.
#pragma once

#include "deformable_surface/base/types.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace deformable_surface::test {

/// The sign of the volume of the tetrahedron: positive if d lies on the side of a b c from which they turn clockwise; 0 where
/// rounding in long double may change it.
inline int findSide(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  using Long = Eigen::Matrix<long double, 3, 1>;
  const Long u = a.cast<long double>() - d.cast<long double>(), v = b.cast<long double>() - d.cast<long double>(),
             w = c.cast<long double>() - d.cast<long double>();
  const long double volume = u.dot(v.cross(w));
  const long double size = u.cwiseAbs().sum() * v.cwiseAbs().sum() * w.cwiseAbs().sum();
  const long double rounding = 64 * std::numeric_limits<long double>::epsilon() * size;
  return volume > rounding ? 1 : volume < -rounding ? -1 : 0;
}

/// Whether the inside of edge p q meets the inside of triangle a b c.
inline bool passesThrough(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const int of_p = findSide(a, b, c, p), of_q = findSide(a, b, c, q);
  if (of_p * of_q >= 0) return false;
  const int ab = findSide(p, q, a, b), bc = findSide(p, q, b, c), ca = findSide(p, q, c, a);
  return ab != 0 && ab == bc && bc == ca;
}

/// Pairs of triangles without a common vertex, an edge of one of which passes through the inside of the other. Touching does not
/// count.
inline std::vector<std::pair<Index, Index>> findCrossings(const Points& positions,
                                                          const std::vector<std::array<Index, 3>>& triangles) {
  const Index n = static_cast<Index>(triangles.size());
  Points low(n), high(n);
  for (Index t = 0; t < n; ++t) {
    const auto& [a, b, c] = triangles[t];
    low[t] = positions[a].cwiseMin(positions[b]).cwiseMin(positions[c]);
    high[t] = positions[a].cwiseMax(positions[b]).cwiseMax(positions[c]);
  }
  std::vector<Index> order(n);  // by the lowest x, so that a sweep sees whose boxes overlap
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Index s, Index t) { return low[s].x() < low[t].x(); });
  std::vector<std::pair<Index, Index>> crossings;
  const auto pierces = [&](Index s, Index t) {
    const auto& one = triangles[s];
    const auto& other = triangles[t];
    for (int k = 0; k < 3; ++k)
      if (passesThrough(positions[one[k]], positions[one[(k + 1) % 3]], positions[other[0]], positions[other[1]],
                        positions[other[2]]))
        return true;
    return false;
  };
  for (Index k = 0; k < n; ++k) {
    const Index s = order[k];
    for (Index m = k + 1; m < n && low[order[m]].x() <= high[s].x(); ++m) {
      const Index t = order[m];
      if ((low[s].array() > high[t].array()).any() || (low[t].array() > high[s].array()).any()) continue;
      const bool are_neighbors = std::any_of(triangles[s].begin(), triangles[s].end(), [&](Index v) {
        return std::find(triangles[t].begin(), triangles[t].end(), v) != triangles[t].end();
      });
      if (!are_neighbors && (pierces(s, t) || pierces(t, s))) crossings.emplace_back(std::min(s, t), std::max(s, t));
    }
  }
  std::sort(crossings.begin(), crossings.end());
  return crossings;
}

}  // namespace deformable_surface::test
