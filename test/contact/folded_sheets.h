// Sheets that lie over each other, for tests of contact.
#pragma once

#include "deformable_surface/contact/pair_list.h"

#include <cmath>
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

/// A closed surface: circles of points between two poles, 5 cm from the middle.
inline Sheets makeBall(Index circles, Index around) {
  Sheets ball;
  for (Index i = 0; i < circles; ++i)
    for (Index k = 0; k < around; ++k) {
      const double down = M_PI * (i + 1) / (circles + 1), about = 2.0 * M_PI * k / around;
      ball.points.push_back(0.05 * Vec3(std::sin(down) * std::cos(about), std::sin(down) * std::sin(about), std::cos(down)));
    }
  const Index top = circles * around, bottom = top + 1;
  ball.points.emplace_back(0.0, 0.0, 0.05);
  ball.points.emplace_back(0.0, 0.0, -0.05);
  for (Index k = 0; k < around; ++k) {
    const Index next = (k + 1) % around, last = (circles - 1) * around;
    ball.triangles.push_back({top, k, next});
    ball.triangles.push_back({bottom, last + next, last + k});
    for (Index i = 0; i + 1 < circles; ++i) {
      const Index a = i * around;
      ball.triangles.push_back({a + k, a + around + k, a + around + next});
      ball.triangles.push_back({a + k, a + around + next, a + next});
    }
  }
  return ball;
}

}  // namespace deformable_surface::test
