#include "deformable_surface/model/elastic_solid/point_volumes.h"
#include "solids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace deformable_surface::test {
namespace {

double sumOf(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

TEST(PointVolumes, AreAHalfOnFacesAQuarterOnEdgesAnEighthAtCorners) {
  const Points box = makeBox(6, 6, 6, 0.1);
  const std::vector<double> volumes = model::findPointCells(box, cloud::nearestNeighbors(box, 32), Vec3::Zero()).volume;
  const auto at = [&](Index i, Index j, Index k) { return volumes[(i * 6 + j) * 6 + k] / 0.001; };
  EXPECT_NEAR(at(2, 3, 2), 1.0, 1e-9);
  EXPECT_NEAR(at(0, 3, 2), 0.5, 1e-9);
  EXPECT_NEAR(at(0, 5, 2), 0.25, 1e-9);
  EXPECT_NEAR(at(0, 5, 0), 0.125, 1e-9);
}

// Where neighbours end cells are cut by them: with jitter of four tenths some reach a little farther than that.
TEST(PointVolumes, SumToTheVolumeOfAJitteredBox) {
  for (const double jitter : {0.0, 0.2, 0.4}) {
    const Points box = makeBox(9, 8, 7, 0.1, jitter);
    EXPECT_NEAR(sumOf(model::findPointCells(box, cloud::nearestNeighbors(box, 32), Vec3::Zero()).volume), 0.8 * 0.7 * 0.6,
                (jitter < 0.3 ? 1e-7 : 1e-4))
        << jitter;
  }
}

TEST(PointVolumes, SumToTheVolumeOfTheHullOfABall) {
  std::mt19937 generator(3);
  Points ball;
  for (const Vec3& p : makeBox(15, 15, 15, 0.1, 0.3))
    if ((p - Vec3::Constant(0.7)).norm() < 0.6) ball.push_back(p);
  const Surface sphere = makeSphere(600, 0.65);
  for (const Vec3& p : sphere.points) ball.push_back(p + Vec3::Constant(0.7));
  const double sum = sumOf(model::findPointCells(ball, cloud::nearestNeighbors(ball, 32), Vec3::Zero()).volume);
  const double whole = 4.0 / 3.0 * M_PI * std::pow(0.65, 3);
  // The hull of points 4 pi R^2 / n apart lies below the sphere by a per cent or so of the radius at most.
  EXPECT_LT(sum, whole);
  EXPECT_GT(sum, 0.97 * whole);
}

TEST(PointVolumes, AreAreasInAPlane) {
  const Points sheet = makeBox(9, 7, 1, 0.1, 0.4);
  const std::vector<double> areas = model::findPointCells(sheet, cloud::nearestNeighbors(sheet, 16), Vec3::UnitZ()).volume;
  EXPECT_NEAR(sumOf(areas), 0.8 * 0.6, 1e-9);
  EXPECT_NEAR(areas[0] / 0.01, 0.25, 0.2);
}

// The outside of a box: outward, and as large as its faces; of an edge both, of a corner all three.
TEST(PointVolumes, HaveTheirPartOfTheOutside) {
  const Points box = makeBox(6, 6, 6, 0.1);
  const Points outside = model::findPointCells(box, cloud::nearestNeighbors(box, 32), Vec3::Zero()).outside;
  const auto at = [&](Index i, Index j, Index k) { return Vec3(outside[(i * 6 + j) * 6 + k] / 0.01); };
  EXPECT_LT((at(2, 3, 2) - Vec3::Zero()).norm(), 1e-9);
  EXPECT_LT((at(0, 3, 2) - Vec3(-1.0, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((at(0, 5, 2) - Vec3(-0.5, 0.5, 0.0)).norm(), 1e-9);
  EXPECT_LT((at(0, 5, 0) - Vec3(-0.25, 0.25, -0.25)).norm(), 1e-9);
  const Points sheet = makeBox(6, 6, 1, 0.1);
  const Points edge = model::findPointCells(sheet, cloud::nearestNeighbors(sheet, 16), Vec3::UnitZ()).outside;
  EXPECT_LT((edge[2] - Vec3(-0.1, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((edge[0] - Vec3(-0.05, -0.05, 0.0)).norm(), 1e-9);
}

TEST(PointVolumes, AreNoneWhereNeighboursLieInAPlane) {
  const Points sheet = makeBox(6, 6, 1, 0.1);
  // Thinner than a thousandth of the spacing.
  EXPECT_LT(sumOf(model::findPointCells(sheet, cloud::nearestNeighbors(sheet, 16), Vec3::Zero()).volume), 0.25 * 1e-4);
}

}  // namespace
}  // namespace deformable_surface::test
