// The star of one point against a brute-force triangulation, and on configurations with ties: grids, lines, copies.
#include "deformable_surface/geometry/delaunay_star.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <utility>

namespace deformable_surface::geometry {
namespace {

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

std::vector<Vec2> makeRandomNeighbors(int n, const Vec2& center, std::mt19937& random) {
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  std::vector<Vec2> points(n);
  for (Vec2& p : points) p = center + Vec2(coordinate(random), coordinate(random));
  return points;
}

// The grid neighbours of one point, rotated, with coordinates rounded to float so that ties break at random.
std::vector<Vec2> makeGridNeighbors(int reach, double spacing, double angle, int min_x = -100) {
  const double c = std::cos(angle), s = std::sin(angle);
  std::vector<Vec2> points;
  for (int x = std::max(-reach, min_x); x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      if (x == 0 && y == 0) continue;
      points.push_back(spacing * Vec2(static_cast<float>(c * x - s * y), static_cast<float>(s * x + c * y)));
    }
  }
  return points;
}

using Pair = std::pair<Index, Index>;

std::set<Pair> findTrianglesByBruteForce(const std::vector<Vec2>& points) {
  std::set<Pair> triangles;
  const Index n = static_cast<Index>(points.size());
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const double area = cross(points[i], points[j]);
      if (!(area > 0.0)) continue;
      Mat2 rows;
      rows << points[i].transpose(), points[j].transpose();
      const Vec2 center = rows.inverse() * Vec2(0.5 * points[i].squaredNorm(), 0.5 * points[j].squaredNorm());
      const bool empty = std::all_of(points.begin(), points.end(), [&](const Vec2& p) {
        return &p == &points[i] || &p == &points[j] || (p - center).squaredNorm() > center.squaredNorm();
      });
      if (empty) triangles.insert({i, j});
    }
  }
  return triangles;
}

std::set<Pair> listTriangles(const DelaunayStar& star) {
  std::set<Pair> triangles;
  for (std::size_t r = 0; r < star.ring.size(); ++r) {
    if (star.cell_size[r] > 0) triangles.insert({star.ring[r], star.ring[(r + 1) % star.ring.size()]});
  }
  return triangles;
}

TEST(DelaunayStar, EqualsBruteForceInsideAndOnTheHull) {
  std::mt19937 random(1);
  DelaunayStarBuilder builder;
  int num_open = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const std::vector<Vec2> points = makeRandomNeighbors(3 + trial % 25, Vec2(0.04 * (trial % 30), 0.0), random);
    const DelaunayStar& star = builder.build(points, 0.0);
    ASSERT_EQ(listTriangles(star), findTrianglesByBruteForce(points)) << "trial " << trial;
    num_open += star.open;
  }
  EXPECT_GT(num_open, 50);
  EXPECT_LT(num_open, 350);
}

TEST(DelaunayStar, RingGoesCounterClockwiseAndAnOpenOneStartsAfterItsGap) {
  std::mt19937 random(2);
  DelaunayStarBuilder builder;
  for (int trial = 0; trial < 100; ++trial) {
    const std::vector<Vec2> points = makeRandomNeighbors(12, Vec2(0.9, 0.0), random);
    const DelaunayStar& star = builder.build(points);
    ASSERT_GE(star.ring.size(), 2u);
    double turned = 0.0;
    for (std::size_t r = 0; r + 1 < star.ring.size(); ++r) {
      const Vec2 &a = points[star.ring[r]], &b = points[star.ring[r + 1]];
      ASSERT_GT(cross(a, b), 0.0);
      turned += std::atan2(cross(a, b), a.dot(b));
      EXPECT_TRUE(!star.open || star.cell_size[r] > 0);
    }
    EXPECT_LT(turned, 2.0 * kPi);
    if (star.open) {
      EXPECT_LE(turned, kPi);
      EXPECT_EQ(star.cell_size.back(), 0);
    }
  }
}

TEST(DelaunayStar, GridPointHasEightNeighborsInFourSquaresHoweverItIsTurned) {
  DelaunayStarBuilder builder;
  for (int turn = 0; turn < 200; ++turn) {
    const double spacing = 0.37;
    const std::vector<Vec2> points = makeGridNeighbors(2, spacing, 0.031 * turn);
    const DelaunayStar& star = builder.build(points);
    ASSERT_EQ(star.ring.size(), 8u) << "turn " << turn;
    EXPECT_FALSE(star.open);
    EXPECT_EQ(std::count(star.cell_size.begin(), star.cell_size.end(), 4), 8);
    EXPECT_NEAR(star.area, 4.0 * spacing * spacing, 1e-6);
    EXPECT_NEAR(star.share, spacing * spacing, 1e-6);
  }
}

TEST(DelaunayStar, GridEdgeHasFiveNeighborsInTwoSquaresAndIsOpen) {
  DelaunayStarBuilder builder;
  for (int turn = 0; turn < 200; ++turn) {
    const std::vector<Vec2> points = makeGridNeighbors(2, 1.0, 0.031 * turn, 0);
    const DelaunayStar& star = builder.build(points, kStarTie, 2.3);
    ASSERT_EQ(star.ring.size(), 5u) << "turn " << turn;
    EXPECT_TRUE(star.open);
    EXPECT_EQ(star.cell_size, (std::vector<Index>{4, 4, 4, 4, 0}));
    EXPECT_NEAR(star.share, 0.5, 1e-6);
  }
}

TEST(DelaunayStar, CocircularHexagonIsOneCell) {
  std::vector<Vec2> points;
  for (int i = 1; i < 6; ++i) points.push_back(Vec2(std::cos(i * kPi / 3.0) - 1.0, std::sin(i * kPi / 3.0)));
  DelaunayStarBuilder builder;
  const DelaunayStar& star = builder.build(points);
  EXPECT_EQ(star.ring.size(), 5u);
  EXPECT_EQ(star.cell_size, (std::vector<Index>{6, 6, 6, 6, 0}));
  const double area = 1.5 * std::sqrt(3.0);
  EXPECT_NEAR(star.area, area, 1e-12);
  EXPECT_NEAR(star.share, area / 6.0, 1e-12);
}

TEST(DelaunayStar, AllCornersOfAQuadrilateralAgreeWhetherItIsTied) {
  // A kite whose far corner leaves the circle step by step: each corner's star must change from the cell to triangles together.
  DelaunayStarBuilder builder;
  int num_tied = 0, num_split = 0;
  for (int step = 0; step < 60; ++step) {
    const std::vector<Vec2> quad{{0.0, 0.0}, {1.0, 0.2}, {0.84 + 0.001 * step, 0.84 + 0.001 * step}, {0.2, 1.0}};
    std::set<Index> sizes;
    double sum = 0.0;
    for (int corner = 0; corner < 4; ++corner) {
      std::vector<Vec2> others;
      for (int other = 0; other < 4; ++other) {
        if (other != corner) others.push_back(quad[other] - quad[corner]);
      }
      const DelaunayStar& star = builder.build(others);
      sizes.insert(star.cell_size[0]);
      sum += star.share;
    }
    const double area = 0.5 * (cross(quad[1], quad[2]) + cross(quad[2], quad[3]));
    EXPECT_NEAR(sum, area, 1e-12) << "step " << step;
    ASSERT_EQ(sizes.size(), 1u) << "step " << step;
    (*sizes.begin() == 4 ? num_tied : num_split)++;
  }
  EXPECT_GT(num_tied, 0);
  EXPECT_GT(num_split, 0);
}

TEST(DelaunayStar, WideAngleSpansNoTriangleBeyondMaxGap) {
  const std::vector<Vec2> points{{1.0, 0.0}, {-0.8, 0.6}, {-0.8, -0.6}};
  DelaunayStarBuilder builder;
  EXPECT_FALSE(builder.build(points).open);
  const DelaunayStar& star = builder.build(points, kStarTie, 2.3);
  EXPECT_TRUE(star.open);
  EXPECT_EQ(std::count(star.cell_size.begin(), star.cell_size.end(), 0), 2);
}

TEST(DelaunayStar, DegenerateNeighborsGiveNoTriangles) {
  DelaunayStarBuilder builder;
  EXPECT_TRUE(builder.build({}).ring.empty());
  EXPECT_TRUE(builder.build({Vec2::Zero(), Vec2::Zero()}).ring.empty());

  const std::vector<std::vector<Vec2>> without_triangles{
      {{0.3, 0.4}}, {{1.0, 1.0}, {2.0, 2.0}, {3.0, 3.0}}, {{1.0, 0.5}, {-1.0, -0.5}, {2.0, 1.0}}, {{1.0, 0.0}, {1.0, 0.0}}};
  for (const std::vector<Vec2>& points : without_triangles) {
    const DelaunayStar& star = builder.build(points);
    EXPECT_TRUE(star.open);
    EXPECT_EQ(star.area, 0.0);
    EXPECT_EQ(star.share, 0.0);
    EXPECT_EQ(star.ring[0], 0);
    for (Index size : star.cell_size) EXPECT_EQ(size, 0);
  }
  EXPECT_EQ(builder.build(without_triangles[1]).ring.size(), 1u);
  EXPECT_EQ(builder.build(without_triangles[2]).ring.size(), 2u);
}

TEST(DelaunayStar, OfCoincidentNeighborsTheFirstCounts) {
  const std::vector<Vec2> points{{1.0, 0.0}, {0.0, 1.0}, {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}, {1.0, 0.0}};
  DelaunayStarBuilder builder;
  const DelaunayStar& star = builder.build(points);
  EXPECT_EQ(std::set<Index>(star.ring.begin(), star.ring.end()), (std::set<Index>{0, 1, 3, 4}));
  EXPECT_NEAR(star.share, 2.0 / 3.0, 1e-12);
}

TEST(DelaunayStar, DoesNotDependOnScaleDownToVerySmallAndUpToVeryLarge) {
  std::mt19937 random(3);
  const std::vector<Vec2> points = makeRandomNeighbors(16, Vec2::Zero(), random);
  DelaunayStarBuilder builder;
  const std::vector<Index> ring = builder.build(points).ring;
  for (double scale : {std::ldexp(1.0, -200), std::ldexp(1.0, -40), std::ldexp(1.0, 200)}) {
    std::vector<Vec2> scaled = points;
    for (Vec2& p : scaled) p *= scale;
    EXPECT_EQ(builder.build(scaled).ring, ring) << scale;
  }
}

TEST(DelaunayStar, PointsInLineOnAnEdgeAreFoundInOrderAtAnyAngle) {
  DelaunayStarBuilder builder;
  for (int turn = 0; turn < 1000; ++turn) {
    // Two neighbours to one side, three to the other, one row inside: rounding puts them on either side of the line.
    const double angle = 0.0063 * turn;
    const Vec2 along(std::cos(angle), std::sin(angle)), inward(-along.y(), along.x());
    const std::vector<Vec2> points{3.0 * along, along, -along, inward, 2.0 * along, -2.0 * along, inward + along, inward - along};
    EXPECT_EQ(builder.build(points).ring, (std::vector<Index>{1, 6, 3, 7, 2})) << "turn " << turn;
  }
}

TEST(DelaunayStar, NeighborsThatAreNotFiniteAreIgnored) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  DelaunayStarBuilder builder;
  const DelaunayStar& star = builder.build({{nan, 1.0}, {1.0, 0.0}, {infinity, 1.0}, {0.0, 1.0}});
  EXPECT_EQ(star.ring, (std::vector<Index>{1, 3}));
}

TEST(DelaunayStar, APointOutsideLeavesItAsItIs) {
  std::mt19937 random(5);
  DelaunayStarBuilder builder;
  int num_outside = 0, num_changes = 0;
  for (int cloud = 0; cloud < 500; ++cloud) {
    std::vector<Vec2> points = makeRandomNeighbors(12, Vec2::Zero(), random);
    const DelaunayStar star = builder.build(points);
    if (star.open) continue;
    const Vec2 more = makeRandomNeighbors(1, Vec2::Zero(), random)[0];
    const bool is_outside = isOutside(more, points, star);
    points.push_back(more);
    const DelaunayStar& with_more = builder.build(points);
    if (is_outside) {
      ASSERT_EQ(star.ring, with_more.ring) << "cloud " << cloud;
      ASSERT_EQ(star.cell_size, with_more.cell_size);
      ASSERT_EQ(star.area, with_more.area);
    }
    num_outside += is_outside;
    num_changes += star.ring != with_more.ring;
  }
  EXPECT_GT(num_outside, 20);
  EXPECT_GT(num_changes, 20);
}

TEST(DelaunayStar, APointOnTheCircleIsNotOutside) {
  const std::vector<Vec2> points{{1.0, 0.0}, {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}};
  DelaunayStarBuilder builder;
  const DelaunayStar& star = builder.build(points);
  ASSERT_FALSE(star.open);
  EXPECT_FALSE(isOutside({1.0, 1.0}, points, star));      // completes a square
  EXPECT_FALSE(isOutside({1.001, 1.001}, points, star));  // within the tie
  EXPECT_FALSE(isOutside({0.4, 0.4}, points, star));
  EXPECT_TRUE(isOutside({1.2, 1.2}, points, star));
  EXPECT_TRUE(isOutside({1.5, 0.0}, points, star));  // behind a member
}

}  // namespace
}  // namespace deformable_surface::geometry
