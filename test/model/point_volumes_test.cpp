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

// At the limit of the neighbours cells are cut by them. With a jitter of four tenths some cells reach a little farther.
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
  // The hull of points 4 pi R^2 / n apart lies below the sphere by at most about a per cent of the radius.
  EXPECT_LT(sum, whole);
  EXPECT_GT(sum, 0.97 * whole);
}

// Of 4096 points all cells are measured, of 27,000 most.
TEST(PointVolumes, AroundFewerPointsSumToTheVolumeOfAll) {
  for (const Index side : {16, 30}) {
    const Points box = makeBox(side, side, side, 0.1, 0.2);
    std::vector<Index> owner;
    for (const Vec3& p : box) owner.push_back((p.x() > 0.45) + 2 * (p.y() > 0.45));
    const std::vector<double> around = model::measureAround(box, cloud::nearestNeighbors(box, 32), Vec3::Zero(), owner, 5);
    const double length = 0.1 * (side - 1), low = 0.45, high = length - low, tolerance = side == 16 ? 0.005 : 0.02;
    EXPECT_NEAR(around[0], low * low * length, tolerance * low * low * length);
    EXPECT_NEAR(around[1], low * high * length, tolerance * low * high * length);
    EXPECT_NEAR(around[2], low * high * length, tolerance * low * high * length);
    EXPECT_NEAR(around[3], high * high * length, tolerance * high * high * length);
    EXPECT_EQ(around[4], 0.0);
  }
}

// Lists that end at a layer, as at a gap: the cell must not reach as far as the neighbours on the other sides.
TEST(PointVolumes, AroundPointsDoNotReachBeyondAllNeighbours) {
  const Points box = makeBox(9, 9, 9, 0.1);
  const Lists all = cloud::nearestNeighbors(box, 32);
  Lists below;
  std::vector<Index> owner;
  for (Index i = 0; i < all.size(); ++i) {
    for (const Index* j = all.begin(i); j != all.end(i); ++j)
      if (box[*j].z() < box[i].z() + 0.05) below.items.push_back(*j);
    below.offsets.push_back(static_cast<Index>(below.items.size()));
    owner.push_back(i);
  }
  const std::vector<double> around = model::measureAround(box, below, Vec3::Zero(), owner, all.size());
  for (Index i = 0; i < all.size(); ++i) EXPECT_LT(around[i], 1.01e-3) << box[i].transpose();
}

TEST(PointVolumes, AreFilledToTheDegreeOfTheirNeighbourhood) {
  Lists neighbors;
  for (const Index other : {1, 0, 3, 2}) {
    neighbors.items.push_back(other);
    neighbors.offsets.push_back(static_cast<Index>(neighbors.items.size()));
  }
  std::vector<double> volume{1.0, 3.0, 2.0, 2.0};
  model::fillCells({2.0, 0.0, 1.0, 3.0}, neighbors, volume);
  EXPECT_EQ(volume, (std::vector<double>{0.5, 1.5, 2.0, 2.0}));
  // The second point has no neighbours.
  neighbors.items = {1};
  neighbors.offsets = {0, 1, 1};
  volume = {1.0, 3.0};
  model::fillCells({1.0, 1.0}, neighbors, volume);
  EXPECT_DOUBLE_EQ(volume[0], 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(volume[1], 4.0 / 3.0);
  // Nothing to fill.
  volume = {0.0, 0.0};
  model::fillCells({1.0, 1.0}, neighbors, volume);
  EXPECT_EQ(volume, (std::vector<double>{0.0, 0.0}));
}

TEST(PointVolumes, AreAreasInAPlane) {
  const Points sheet = makeBox(9, 7, 1, 0.1, 0.4);
  const std::vector<double> areas = model::findPointCells(sheet, cloud::nearestNeighbors(sheet, 16), Vec3::UnitZ()).volume;
  EXPECT_NEAR(sumOf(areas), 0.8 * 0.6, 1e-9);
  EXPECT_NEAR(areas[0] / 0.01, 0.25, 0.2);
}

// The outside of a box: outward, as large as its faces. An edge point has both faces, a corner point all three.
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

// A ring with eight points through its wall. The volume is the area between the polygons through its points. Every point on the
// inner circle has its part of the outside, towards the middle. Rough outlines keep the hull, which covers part of the hole.
TEST(PointVolumes, EndAtTheCircleOfAHole) {
  for (const double jitter : {0.0, 0.3}) {
    const QuarterRing ring = makeQuarterRing(2.0, 8, jitter);
    const Lists neighbors = cloud::nearestNeighbors(ring.points, 16);
    const double whole = 0.25 * M_PI * 3.0;
    const model::PointCells cells = model::findPointCells(ring.points, neighbors, Vec3::UnitZ());
    EXPECT_NEAR(sumOf(cells.volume) / whole, 1.0, 0.003) << jitter;
    EXPECT_GT(sumOf(model::findPointCells(ring.points, neighbors, Vec3::UnitZ(), model::Outline::kRough).volume) / whole, 1.02);
    for (std::size_t k = 1; k + 1 < ring.inner.size(); ++k) {
      const Vec3 inward = -ring.length[k] * ring.points[ring.inner[k]];
      EXPECT_LT((cells.outside[ring.inner[k]] - inward).norm(), 0.07 * ring.length[k]) << jitter << " " << k;
    }
  }
}

// A ball with a hollow of half its radius: a lattice between points on both spheres.
TEST(PointVolumes, SumToTheVolumeOfAHollowBall) {
  const double spacing = 0.15;
  Points ball;
  for (const double radius : {0.5, 1.0})
    for (const Vec3& p : makeSphere(static_cast<Index>(4.0 * M_PI * radius * radius / (spacing * spacing)), radius).points)
      ball.push_back(p);
  for (const Vec3& p : makeBox(15, 15, 15, spacing, 0.2)) {
    const double distance = (p - Vec3::Constant(7.0 * spacing)).norm();
    if (distance > 0.5 + 0.6 * spacing && distance < 1.0 - 0.6 * spacing) ball.push_back(p - Vec3::Constant(7.0 * spacing));
  }
  const double whole = 4.0 / 3.0 * M_PI * (1.0 - 0.125);
  const Lists neighbors = cloud::nearestNeighbors(ball, 32);
  EXPECT_NEAR(sumOf(model::findPointCells(ball, neighbors, Vec3::Zero()).volume) / whole, 1.0, 0.01);
  EXPECT_GT(sumOf(model::findPointCells(ball, neighbors, Vec3::Zero(), model::Outline::kRough).volume) / whole, 1.02);
}

// Beside a concave edge points have half a cell. At the edge itself three points look like the corners of a body: half a square
// between two neighbours remains.
TEST(PointVolumes, EndAtAConcaveEdge) {
  const Index n = 6;  // cells of each arm's width
  Points ell;
  std::vector<double> expected;
  for (Index i = 0; i <= 2 * n; ++i)
    for (Index j = 0; j <= 2 * n; ++j) {
      if (i > n && j > n) continue;
      ell.emplace_back(0.1 * i, 0.1 * j, 0.0);
      const bool is_side = (i == n && j > n) || (j == n && i > n);
      expected.push_back(is_side && i < 2 * n && j < 2 * n ? 0.5 : -1.0);
      if (is_side && i + j == 2 * n + 1) expected.back() = 0.625;
    }
  const std::vector<double> areas = model::findPointCells(ell, cloud::nearestNeighbors(ell, 16), Vec3::UnitZ()).volume;
  for (std::size_t i = 0; i < ell.size(); ++i)
    if (expected[i] > 0.0) {
      EXPECT_NEAR(areas[i] / 0.01, expected[i], 1e-6) << ell[i].transpose();
    }
  EXPECT_NEAR(sumOf(areas) / 0.01, 3.0 * n * n + 0.5, 1e-6);
}

// Gaps between jittered points do not count as gaps: the bits are the same for any stated outline.
TEST(PointVolumes, AreThoseOfTheHullOfAConvexBody) {
  for (const double jitter : {0.2, 0.4}) {
    for (const Points& points :
         {makeBox(9, 8, 7, 0.1, jitter), makeBox(30, 2, 2, 0.1, jitter), makeBox(20, 15, 1, 0.1, jitter)}) {
      const bool is_planar = points.size() == 300;
      const Vec3 across = is_planar ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::Zero());
      const Lists neighbors = cloud::nearestNeighbors(points, is_planar ? 16 : 32);
      const model::PointCells cells = model::findPointCells(points, neighbors, across);
      const model::PointCells of_hull = model::findPointCells(points, neighbors, across, model::Outline::kRough);
      EXPECT_EQ(cells.volume, of_hull.volume) << jitter;
      EXPECT_EQ(cells.outside, of_hull.outside) << jitter;
    }
  }
}

TEST(PointVolumes, AreNoneWhereNeighboursLieInAPlane) {
  const Points sheet = makeBox(6, 6, 1, 0.1);
  // Thinner than a thousandth of the spacing.
  EXPECT_LT(sumOf(model::findPointCells(sheet, cloud::nearestNeighbors(sheet, 16), Vec3::Zero()).volume), 0.25 * 1e-4);
}

}  // namespace
}  // namespace deformable_surface::test
