// Closest points of a vertex and a triangle, and of two edges.
#include "deformable_surface/contact/closest_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "../support/surfaces.h"

namespace deformable_surface::contact {
namespace {

constexpr int kSteps = 60;

// Gap and weights agree. The weights are those of two points within their primitives.
void expectConsistent(const Closest& closest, const std::array<Vec3, 4>& x, int num_first) {
  Vec3 gap = Vec3::Zero();
  double first = 0.0, second = 0.0;
  for (int v = 0; v < 4; ++v) {
    const double sign = v < num_first ? 1.0 : -1.0;
    EXPECT_GE(sign * closest.weight[v], -1e-12);
    (v < num_first ? first : second) += closest.weight[v];
    gap += closest.weight[v] * x[v];
  }
  EXPECT_NEAR(first, 1.0, 1e-12);
  EXPECT_NEAR(second, -1.0, 1e-12);
  EXPECT_LT((gap - closest.gap).norm(), 1e-12);
}

TEST(ClosestPoints, OfAVertexAndATriangleAreNoFartherThanAnyOthers) {
  std::mt19937 generator(3);
  for (int trial = 0; trial < 200; ++trial) {
    std::array<Vec3, 4> x;
    for (Vec3& point : x) point = test::randomVector(generator);
    if (trial % 4 == 1) x[3] = x[1] + 0.3 * (x[2] - x[1]);  // a line
    if (trial % 4 == 2) x[2] = x[3] = x[1];                 // a point
    const Closest closest = findClosestToTriangle(x[0], x[1], x[2], x[3]);
    expectConsistent(closest, x, 1);
    double least = 10.0;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j) {
        const double b = 1.0 * i / kSteps, c = 1.0 * j / kSteps;
        least = std::min(least, (x[0] - ((1.0 - b - c) * x[1] + b * x[2] + c * x[3])).norm());
      }
    EXPECT_LE(closest.gap.norm(), least + 1e-12) << trial;
    EXPECT_GE(closest.gap.norm(), least - 0.05) << trial;
  }
}

TEST(ClosestPoints, OfTwoEdgesAreNoFartherThanAnyOthers) {
  std::mt19937 generator(5);
  for (int trial = 0; trial < 200; ++trial) {
    std::array<Vec3, 4> x;
    for (Vec3& point : x) point = test::randomVector(generator);
    if (trial % 4 == 1) x[3] = x[2] + 0.7 * (x[1] - x[0]);  // parallel
    if (trial % 4 == 2) x[1] = x[0];                        // a point
    if (trial % 4 == 3) x[1] = x[0], x[3] = x[2];           // two points
    const Closest closest = findClosestOfEdges(x[0], x[1], x[2], x[3]);
    expectConsistent(closest, x, 2);
    double least = 10.0;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; j <= kSteps; ++j) {
        const double s = 1.0 * i / kSteps, t = 1.0 * j / kSteps;
        least = std::min(least, (x[0] + s * (x[1] - x[0]) - x[2] - t * (x[3] - x[2])).norm());
      }
    EXPECT_LE(closest.gap.norm(), least + 1e-12) << trial;
    EXPECT_GE(closest.gap.norm(), least - 0.05) << trial;
  }
}

}  // namespace
}  // namespace deformable_surface::contact
