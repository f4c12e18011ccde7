// The fit of a linear map to the motion of neighbours: exact for linear motions, symmetric in its weights.
#include "deformable_surface/model/elastic_solid/fitted_gradients.h"

#include "deformable_surface/cloud/kd_tree.h"
#include "solids.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

constexpr Index kSide = 5;
constexpr double kReach = 2.5;  // spacings

model::PairFit fit(const Points& points, const std::vector<double>& detours = {}) {
  return model::fitPairs(points, cloud::nearestNeighbors(points, 30), detours, kReach);
}

// F_i of a motion of the points.
Mat3 findMap(const model::PairFit& fit, const Points& moved, Index i) {
  Mat3 A = Mat3::Zero();
  for (Index k = fit.pairs.offsets[i]; k < fit.pairs.offsets[i + 1]; ++k) {
    const Vec3 m(fit.m[4 * k], fit.m[4 * k + 1], fit.m[4 * k + 2]);
    A += (moved[fit.pairs.items[k]] - moved[i]) * m.transpose();
  }
  return A * fit.inverseAt(i);
}

TEST(FittedGradients, AreExactForLinearMotions) {
  const Points rest = makeBox(kSide, kSide, kSide, 0.1, 0.3);
  const model::PairFit f = fit(rest);
  Mat3 map;
  map << 1.1, 0.2, 0.0, -0.1, 0.9, 0.3, 0.0, 0.1, 1.2;
  Points moved = rest;
  for (Vec3& p : moved) p = map * p + Vec3(3.0, -1.0, 0.5);
  for (Index i = 0; i < f.size(); ++i) {
    EXPECT_EQ(f.rank[i], 3) << i;
    EXPECT_LT((findMap(f, moved, i) - map).norm(), 1e-9) << i;
  }
}

TEST(FittedGradients, WeighAPairTheSameFromBothEnds) {
  const Points rest = makeBox(kSide, kSide, kSide, 0.1, 0.3);
  const model::PairFit f = fit(rest);
  for (Index i = 0; i < f.size(); ++i)
    for (Index k = f.pairs.offsets[i]; k < f.pairs.offsets[i + 1]; ++k) {
      const Index j = f.pairs.items[k];
      const Index* const back = std::lower_bound(f.pairs.begin(j), f.pairs.end(j), i);
      ASSERT_TRUE(back != f.pairs.end(j) && *back == i) << i << " " << j;
      const Index at = f.pairs.offsets[j] + static_cast<Index>(back - f.pairs.begin(j));
      EXPECT_EQ(f.m[4 * k + 3], f.m[4 * at + 3]);
    }
}

TEST(FittedGradients, CountTheDirectionsInWhichNeighboursSpread) {
  const Points plane = makeBox(kSide, kSide, 1, 0.1);
  const model::PairFit f = fit(plane);
  for (Index i = 0; i < f.size(); ++i) EXPECT_EQ(f.rank[i], 2) << i;
  Points moved = plane;
  for (Vec3& p : moved) p.x() *= 1.3;
  EXPECT_NEAR(findMap(f, moved, 12)(0, 0), 1.3, 1e-9);
}

TEST(FittedGradients, LeaveOutPairsWhoseDetourCountsNothing) {
  const Points rest = makeBox(kSide, kSide, kSide, 0.1);
  const Lists neighbors = cloud::nearestNeighbors(rest, 30);
  std::vector<double> detours(neighbors.items.size(), 1.0);
  // The first point and the others do not affect each other, in either direction.
  for (Index i = 0; i < neighbors.size(); ++i)
    for (Index k = neighbors.offsets[i]; k < neighbors.offsets[i + 1]; ++k)
      if (i == 0 || neighbors.items[k] == 0) detours[k] = 0.0;
  const model::PairFit f = model::fitPairs(rest, neighbors, detours, kReach);
  EXPECT_EQ(f.pairs.count(0), 0);
  EXPECT_EQ(f.rank[0], 0);
  EXPECT_GT(f.pairs.count(1), 3);
}

}  // namespace
}  // namespace deformable_surface::test
