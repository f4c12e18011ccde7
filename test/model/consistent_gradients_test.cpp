#include "solids.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using model::ConsistentGradients;
using model::PairFit;
using model::PointCells;

struct Gradients {
  Points points;
  PointCells cells;
  PairFit fit;
  ConsistentGradients corrected;
};

Gradients makeGradients(double jitter) {
  Gradients g;
  g.points = makeBox(8, 6, 6, 0.1, jitter);
  const Lists neighbors = cloud::nearestNeighbors(g.points, 32);
  g.cells = model::findPointCells(g.points, neighbors, Vec3::Zero());
  g.fit = model::fitPairs(g.points, neighbors, {}, 2.0);
  g.corrected = model::makeConsistent(g.points, g.fit, g.cells);
  return g;
}

Eigen::Map<const Vec3> rowAt(const std::vector<double>& rows, Index k, Index width = 3) {
  return Eigen::Map<const Vec3>(rows.data() + width * k);
}

// sum_i V_i g_i(j): the integral of the gradient of j's shape function.
Points integrate(const Gradients& g, bool is_corrected) {
  Points integral(g.points.size(), Vec3::Zero());
  for (Index i = 0; i < g.fit.size(); ++i)
    for (Index k = g.fit.pairs.offsets[i]; k < g.fit.pairs.offsets[i + 1]; ++k) {
      const Vec3 row = is_corrected ? Vec3(rowAt(g.corrected.row, k)) : Vec3(g.fit.inverseAt(i) * rowAt(g.fit.m, k, 4));
      integral[g.fit.pairs.items[k]] += g.cells.volume[i] * row;
      integral[i] -= g.cells.volume[i] * row;
    }
  return integral;
}

TEST(ConsistentGradients, AreExactForLinearMotionsOnJitteredPoints) {
  const Gradients g = makeGradients(0.3);
  for (Index i = 0; i < g.fit.size(); ++i) {
    Mat3 sum = Mat3::Zero();
    for (Index k = g.fit.pairs.offsets[i]; k < g.fit.pairs.offsets[i + 1]; ++k)
      sum += (g.points[g.fit.pairs.items[k]] - g.points[i]) * rowAt(g.corrected.row, k).transpose();
    EXPECT_LT((sum - Mat3::Identity()).norm(), 1e-11) << i;
  }
}

// Inside, the sum is zero: uniform stress is in balance. Without the correction a good part of a facet (0.01 m^2) remains.
TEST(ConsistentGradients, KeepGausssTheoremOnJitteredPoints) {
  const Gradients g = makeGradients(0.3);
  double fitted = 0.0, corrected = 0.0;
  const Points before = integrate(g, false), after = integrate(g, true);
  for (std::size_t j = 0; j < g.points.size(); ++j) {
    if (g.cells.outside[j].norm() > 1e-12) continue;
    fitted = std::max(fitted, before[j].norm());
    corrected = std::max(corrected, after[j].norm());
  }
  EXPECT_GT(fitted, 1e-3);
  EXPECT_LT(corrected, 1e-12);
  EXPECT_LT(g.corrected.residual, 1e-9);
}

// On the faces the sum is their area, except for the shift that makes the theorem possible.
TEST(ConsistentGradients, LeaveTheAreaOfTheOutside) {
  const Gradients g = makeGradients(0.2);
  const Points after = integrate(g, true);
  for (std::size_t j = 0; j < g.points.size(); ++j)
    EXPECT_LT((after[j] - g.cells.outside[j]).norm(), 0.02 * g.cells.outside[j].norm() + 1e-12) << j;
}

Gradients makeGradientsOf(Points points, const Vec3& across) {
  Gradients g;
  g.points = std::move(points);
  const Lists neighbors = cloud::nearestNeighbors(g.points, across.isZero(0.0) ? 32 : 16);
  g.cells = model::findPointCells(g.points, neighbors, across);
  g.fit = model::fitPairs(g.points, neighbors, {}, 2.0);
  g.corrected = model::makeConsistent(g.points, g.fit, g.cells);
  return g;
}

// Two bodies in one cloud: the correction of one does not use points of the other.
TEST(ConsistentGradients, KeepGausssTheoremOfEveryBody) {
  Points points = makeBox(6, 5, 5, 0.1, 0.3);
  for (const Vec3& p : makeBox(5, 6, 4, 0.1, 0.3, 7)) points.push_back(p + Vec3(5.0, 0.0, 0.0));
  EXPECT_LT(makeGradientsOf(points, Vec3::Zero()).corrected.residual, 1e-8);
}

// Random points: some have one or two neighbours, where the theorem cannot hold. The remaining error is smaller than without the
// correction, and the rows keep the size of those of the fits.
TEST(ConsistentGradients, AreNoWorseWhereTheTheoremCannotHold) {
  std::mt19937 generator(1);
  Points points(100);
  for (Vec3& p : points) {
    p = randomVector(generator);
    p.z() = 0.0;
  }
  const Gradients g = makeGradientsOf(points, Vec3::UnitZ());
  EXPECT_LT(*std::min_element(g.fit.rank.begin(), g.fit.rank.end()), 2);
  EXPECT_LE(g.corrected.residual, 1.0);
  double fitted = 0.0, corrected = 0.0;
  for (Index i = 0; i < g.fit.size(); ++i)
    for (Index k = g.fit.pairs.offsets[i]; k < g.fit.pairs.offsets[i + 1]; ++k) {
      fitted = std::max(fitted, (g.fit.inverseAt(i) * rowAt(g.fit.m, k, 4)).norm());
      corrected = std::max(corrected, rowAt(g.corrected.row, k).norm());
    }
  EXPECT_LT(corrected, 10.0 * fitted);
}

}  // namespace
}  // namespace deformable_surface::test
