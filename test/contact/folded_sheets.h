// Sheets that lie over each other, for tests of contact.
#pragma once

#include "deformable_surface/contact/pair_list.h"

#include <random>
#include <vector>

#include "../support/surfaces.h"

namespace deformable_surface::test {

struct Sheets {
  Points points;
  std::vector<contact::Triangle> triangles;
};

/// num sheets of n x n points, 0.1 m wide and gap (m) apart, moved along their planes and jittered in three dimensions by
/// `jitter` (m). A sheet may be moved against another without changing which points belong together.
inline Sheets makeSheets(int num, int n, double gap, double jitter, unsigned seed = 1) {
  std::mt19937 generator(seed);
  Sheets sheets;
  for (int s = 0; s < num; ++s) {
    const Index first = static_cast<Index>(sheets.points.size());
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        sheets.points.push_back(Vec3(0.1 * i / (n - 1) + 0.003 * s, 0.1 * j / (n - 1) - 0.002 * s, gap * s) +
                                jitter * randomVector(generator));
    for (int i = 0; i + 1 < n; ++i)
      for (int j = 0; j + 1 < n; ++j) {
        const Index a = first + i * n + j, b = a + n;
        sheets.triangles.push_back({a, b, b + 1});
        sheets.triangles.push_back({a, b + 1, a + 1});
      }
  }
  return sheets;
}

}  // namespace deformable_surface::test
