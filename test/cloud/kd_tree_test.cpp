// The kd-tree against a search through all points, with ties, removal and degenerate clouds.
#include "deformable_surface/cloud/kd_tree.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace deformable_surface::cloud {
namespace {

Points makeRandomPoints(Index n, double scale, unsigned seed) {
  std::mt19937 random(seed);
  Points points(n);
  for (Vec3& p : points) {
    for (int axis = 0; axis < 3; ++axis) p[axis] = scale * (random() / 4294967296.0 - 0.5);
  }
  return points;
}

// A lattice, so that nearly all distances are ties. Every point is repeated.
Points makeLatticeTwice(Index side) {
  Points points;
  for (int copy = 0; copy < 2; ++copy) {
    for (Index x = 0; x < side; ++x) {
      for (Index y = 0; y < side; ++y) points.emplace_back(x, y, 0.0);
    }
  }
  return points;
}

std::vector<Neighbor> searchAll(const Points& points, const std::vector<char>& alive, const Vec3& query) {
  std::vector<Neighbor> all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!alive[i]) continue;
    const double dx = points[i].x() - query.x(), dy = points[i].y() - query.y(), dz = points[i].z() - query.z();
    all.push_back({dx * dx + dy * dy + dz * dz, static_cast<Index>(i)});
  }
  std::sort(all.begin(), all.end());
  return all;
}

void expectSame(const std::vector<Neighbor>& expected, const std::vector<Neighbor>& found) {
  ASSERT_EQ(expected.size(), found.size());
  for (std::size_t m = 0; m < found.size(); ++m) {
    ASSERT_EQ(expected[m].index, found[m].index) << "place " << m;
    ASSERT_EQ(expected[m].squared_distance, found[m].squared_distance) << "place " << m;
  }
}

// Queries at and between the points, with and without removal, against a search through all points.
void compareWithFullSearch(const Points& points) {
  KdTree tree(points);
  std::vector<char> alive(points.size(), 1);
  std::mt19937 random(3);
  std::vector<Neighbor> found;
  for (int round = 0; round < 6; ++round) {
    for (int trial = 0; trial < 20; ++trial) {
      Vec3 query = points[random() % points.size()];
      if (trial % 2 == 1) query = 0.5 * (query + points[random() % points.size()]);
      std::vector<Neighbor> expected = searchAll(points, alive, query);
      const Index k = 1 + static_cast<Index>(random() % 24);
      // The radius equals the distance of a point. The ball must be closed.
      const std::size_t some = expected.empty() ? 0 : std::min<std::size_t>(k, expected.size() - 1);
      const double radius = expected.empty() ? 0.0 : std::sqrt(expected[some].squared_distance);
      std::vector<Neighbor> expected_ball;
      for (const Neighbor& e : expected) {
        if (e.squared_distance <= radius * radius) expected_ball.push_back(e);
      }
      if (static_cast<Index>(expected.size()) > k) expected.resize(k);
      tree.nearest(query, k, found);
      expectSame(expected, found);
      tree.withinRadius(query, radius, found);
      expectSame(expected_ball, found);
    }
    // Removes about half of the remaining points.
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (alive[i] && random() % 2 == 0) {
        tree.remove(static_cast<Index>(i));
        alive[i] = 0;
      }
    }
  }
}

TEST(KdTree, AgreesWithFullSearchOnRandomPoints) { compareWithFullSearch(makeRandomPoints(1000, 1.0, 1)); }
TEST(KdTree, BreaksTiesByIndexOnRepeatedLattice) { compareWithFullSearch(makeLatticeTwice(20)); }
TEST(KdTree, AgreesWithFullSearchAtHugeScale) { compareWithFullSearch(makeRandomPoints(500, 1e6, 2)); }
TEST(KdTree, AgreesWithFullSearchAtTinyScale) { compareWithFullSearch(makeRandomPoints(500, 1e-25, 2)); }
TEST(KdTree, AgreesWithFullSearchOnFewPoints) {
  for (Index n = 1; n <= 25; ++n) compareWithFullSearch(makeRandomPoints(n, 1.0, 7));
}
TEST(KdTree, AgreesWithFullSearchOnLine) {
  Points line;
  for (int i = 0; i < 300; ++i) line.emplace_back(0.1 * i, 0.2 * i, -0.3 * i);
  compareWithFullSearch(line);
}
TEST(KdTree, AgreesWithFullSearchWhenAllCoincide) { compareWithFullSearch(Points(300, Vec3(1.0, 2.0, 3.0))); }

TEST(KdTree, FindsTheNearestWithinReach) {
  const Points points = makeRandomPoints(1000, 1.0, 4);
  const KdTree tree(points);
  std::vector<Neighbor> all, found;
  tree.nearest(points[3], 8, all);
  for (Index within = 1; within < 8; ++within) {
    tree.nearest(points[3], 8, found,
                 0.5 * (std::sqrt(all[within - 1].squared_distance) + std::sqrt(all[within].squared_distance)));
    ASSERT_EQ(within, static_cast<Index>(found.size()));
    for (Index k = 0; k < within; ++k) EXPECT_EQ(all[k].index, found[k].index);
  }
  tree.nearest(points[3], 3, found, 10.0);
  EXPECT_EQ(3u, found.size());
}

TEST(KdTree, IsEmptyWithoutPoints) {
  const KdTree tree{Points()};
  std::vector<Neighbor> found(3);
  tree.nearest(Vec3::Zero(), 5, found);
  EXPECT_TRUE(found.empty());
  tree.withinRadius(Vec3::Zero(), 1.0, found);
  EXPECT_TRUE(found.empty());
  EXPECT_EQ(0, tree.size());
}

TEST(KdTree, HoldsItsPointsInTheirPlacesUntilOneIsRemoved) {
  Points points = makeRandomPoints(100, 1.0, 5);
  KdTree tree(points);
  EXPECT_TRUE(tree.holds(points));
  std::swap(points[3], points[80]);
  EXPECT_FALSE(tree.holds(points));
  std::swap(points[3], points[80]);
  tree.remove(80);
  EXPECT_FALSE(tree.holds(points));
  points.pop_back();
  EXPECT_FALSE(tree.holds(points));
}

TEST(KdTree, OrderNamesEveryPointOnceAndKeepsNearPointsTogether) {
  const Points points = makeRandomPoints(4000, 1.0, 5);
  const KdTree tree(points);
  double step = 0.0;
  for (std::size_t s = 1; s < points.size(); ++s) step += (points[tree.order()[s]] - points[tree.order()[s - 1]]).norm();
  EXPECT_LT(step / 4000.0, 0.15);  // two random points of the cube are 0.66 apart
  std::vector<Index> sorted = tree.order();
  std::sort(sorted.begin(), sorted.end());
  for (Index i = 0; i < 4000; ++i) ASSERT_EQ(i, sorted[i]);
}

// Sizes at which branches that are built side by side have equal and different numbers of nodes.
TEST(KdTree, BuiltInBranchesAgreesWithFullSearch) {
  for (const Index n : {4096, 4097, 20001, 69999, 131072}) {
    const Points points = makeRandomPoints(n, 1.0, 3);
    setNumThreads(3);
    const KdTree tree(points);
    setNumThreads(1);
    const KdTree alone(points);
    setNumThreads(0);
    EXPECT_EQ(tree.order(), alone.order());
    std::vector<Neighbor> found;
    for (Index i = 0; i < n; i += n / 7) {
      tree.nearest(points[i], 20, found);
      const std::vector<Neighbor> all = searchAll(points, std::vector<char>(n, 1), points[i]);
      for (std::size_t k = 0; k < found.size(); ++k) ASSERT_EQ(found[k].index, all[k].index) << n << ", " << i;
    }
  }
}

TEST(KdTree, RefusesWhatItCannotAnswer) {
  EXPECT_THROW(KdTree(Points(1, Vec3(0.0, std::nan(""), 0.0))), InputError);
  EXPECT_THROW(KdTree(Points(1, Vec3(INFINITY, 0.0, 0.0))), InputError);
  KdTree tree(makeRandomPoints(30, 1.0, 1));
  std::vector<Neighbor> found;
  EXPECT_THROW(tree.nearest(Vec3::Zero(), -1, found), InputError);
  EXPECT_THROW(tree.nearest(Vec3::Zero(), 1, found, -1.0), InputError);
  EXPECT_THROW(tree.withinRadius(Vec3::Zero(), -1.0, found), InputError);
  EXPECT_THROW(tree.withinRadius(Vec3::Zero(), std::nan(""), found), InputError);
  EXPECT_THROW(tree.remove(30), InputError);
  EXPECT_THROW(tree.remove(-1), InputError);
  tree.remove(4);
  EXPECT_THROW(tree.remove(4), InputError);
  for (Index i = 10; i < 30; ++i) tree.remove(i);
  EXPECT_THROW(tree.remove(4), InputError);
  EXPECT_THROW(tree.remove(12), InputError);
  EXPECT_EQ(30, tree.size());
}

TEST(NearestNeighbors, ListTheOthersNearestFirst) {
  const Points points = makeLatticeTwice(15);
  const Lists lists = nearestNeighbors(points, 9);
  const std::vector<char> alive(points.size(), 1);
  for (Index i = 0; i < lists.size(); ++i) {
    ASSERT_EQ(9, lists.count(i));
    Index place = 0;
    for (const Neighbor& e : searchAll(points, alive, points[i])) {
      if (e.index == i) continue;
      if (place == 9) break;
      ASSERT_EQ(e.index, lists.begin(i)[place++]);
    }
  }
}

// Points that are searched together find too few candidates, or too many, where the density changes.
TEST(NearestNeighbors, AreThoseOfSingleSearchesWhereTheDensityChanges) {
  Points points = makeRandomPoints(3000, 1.0, 4);
  for (Vec3& p : points) p = Vec3(std::pow(2.0 * p.x(), 9), p.y(), p.x() > 0.3 ? p.z() : 0.0);
  points.resize(3200, Vec3(0.1, 0.2, 0.3));  // and many at one place
  points.emplace_back(1e4, 0.0, 0.0);
  const KdTree tree(points);
  for (const Index k : {1, 8, 40}) {
    const Lists lists = nearestNeighbors(points, k);
    std::vector<Neighbor> found;
    for (Index i = 0; i < lists.size(); ++i) {
      ASSERT_EQ(k, lists.count(i));
      tree.nearest(points[i], k + 1, found);
      const Index* listed = lists.begin(i);
      for (Index m = 0; listed != lists.end(i); ++m) {
        if (found[m].index == i) continue;
        ASSERT_EQ(found[m].index, *listed++) << i;
      }
    }
  }
}

TEST(NearestNeighbors, NeverListThePointItselfAmongCoincidentOnes) {
  const Lists lists = nearestNeighbors(Points(50, Vec3(1.0, 1.0, 1.0)), 4);
  for (Index i = 0; i < 50; ++i) {
    ASSERT_EQ(4, lists.count(i));
    for (const Index* j = lists.begin(i); j != lists.end(i); ++j) ASSERT_NE(i, *j);
  }
}

TEST(NearestNeighbors, AreFewerInSmallClouds) {
  EXPECT_EQ(0, nearestNeighbors(Points(), 16).size());
  for (Index n = 1; n <= 4; ++n) {
    const Lists lists = nearestNeighbors(makeRandomPoints(n, 1.0, 1), 3);
    ASSERT_EQ(n, lists.size());
    for (Index i = 0; i < n; ++i) EXPECT_EQ(std::min(n - 1, Index{3}), lists.count(i));
  }
  EXPECT_TRUE(nearestNeighbors(makeRandomPoints(5, 1.0, 1), 0).items.empty());
  EXPECT_THROW(nearestNeighbors(makeRandomPoints(5, 1.0, 1), -1), InputError);
}

TEST(NearestNeighbors, DoNotDependOnTheNumberOfThreads) {
  const Points points = makeRandomPoints(5000, 1.0, 9);
  setNumThreads(1);
  const Lists one = nearestNeighbors(points, 16);
  setNumThreads(3);
  const Lists three = nearestNeighbors(points, 16);
  setNumThreads(0);
  EXPECT_EQ(one.items, three.items);
}

}  // namespace
}  // namespace deformable_surface::cloud
