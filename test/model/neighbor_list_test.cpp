#include "deformable_surface/model/oriented_particles/neighbor_list.h"

#include "../support/surfaces.h"
#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace deformable_surface::test {
namespace {

using model::NeighborList;

constexpr double kRadius = 0.1, kSkin = 0.02;

std::vector<Index> listOf(const NeighborList& lists, Index i) { return {lists.begin(i), lists.end(i)}; }

/// Every pair within the distance, by comparison of all pairs.
std::vector<Index> findNear(const Points& points, Index i, double distance) {
  std::vector<Index> near;
  for (Index j = 0; j < static_cast<Index>(points.size()); ++j)
    if (j != i && (points[j] - points[i]).squaredNorm() <= distance * distance) near.push_back(j);
  return near;
}

void expectAllPairs(const Points& points) {
  NeighborList lists(kRadius, kSkin);
  ASSERT_TRUE(lists.update(points));
  for (Index i = 0; i < static_cast<Index>(points.size()); ++i)
    EXPECT_EQ(listOf(lists, i), findNear(points, i, kRadius + kSkin)) << i;
}

Points randomPoints(Index n, double size, unsigned seed = 1) {
  std::mt19937 generator(seed);
  Points points(n);
  for (Vec3& p : points) p = size * randomVector(generator);
  return points;
}

TEST(NeighborList, HoldsWhatComparingAllWithAllFindsInAscendingOrder) {
  expectAllPairs(randomPoints(2500, 0.6));  // more than one block, and cells on both sides of zero
  expectAllPairs(randomPoints(300, 0.05));  // all in a few cells
  expectAllPairs(randomPoints(3, 0.1));
  expectAllPairs({Vec3(0.3, 0.2, 0.1)});
  expectAllPairs({});
  expectAllPairs(makeSphere(1500, 1.0).points);
  Points clusters = randomPoints(900, 0.03);
  for (std::size_t i = 0; i < clusters.size(); ++i) clusters[i] += Vec3(i % 3, 5.0 * (i % 2), -2.0 * (i % 5));
  expectAllPairs(clusters);
}

// Short and long lists are sorted in different ways.
TEST(NeighborList, SortsListsOfEveryLength) {
  for (Index n = 1; n < 140; ++n) expectAllPairs(randomPoints(n, 0.03, n));
}

TEST(NeighborList, LeavesOutThoseThatAreApartAndWhatDescendsFromThem) {
  // In a row, each near all others; the first and the third are apart.
  Lists apart;
  apart.items = {2, 0};
  apart.offsets = {0, 1, 1, 2};
  NeighborList lists(kRadius, kSkin, apart);
  const Points row{Vec3(0.0, 0.0, 0.0), Vec3(0.01, 0.0, 0.0), Vec3(0.02, 0.0, 0.0), Vec3(0.03, 0.0, 0.0), Vec3(0.04, 0.0, 0.0)};
  std::vector<model::ParticleTraits> traits(5);
  for (Index i = 0; i < 3; ++i) traits[i].ancestor = i;
  traits[3].ancestor = 2;  // added
  traits[4].ancestor = 4;  // added later, without a first parent
  ASSERT_TRUE(lists.update(row, traits));
  EXPECT_EQ(listOf(lists, 0), (std::vector<Index>{1, 4}));
  EXPECT_EQ(listOf(lists, 1), (std::vector<Index>{0, 2, 3, 4}));
  EXPECT_EQ(listOf(lists, 2), (std::vector<Index>{1, 3, 4}));
  EXPECT_EQ(listOf(lists, 3), (std::vector<Index>{1, 2, 4}));
  const auto apartOf = [&](Index i) {
    std::vector<Index> found;
    for (const NeighborList::Apart* j = lists.beginApart(i); j != lists.endApart(i); ++j) found.push_back(j->particle);
    return found;
  };
  EXPECT_EQ(apartOf(0), (std::vector<Index>{2, 3}));
  EXPECT_EQ(apartOf(1), std::vector<Index>{});
  EXPECT_EQ(apartOf(3), std::vector<Index>{0});
  // Only those that can come within their range before the next rebuild.
  lists.setApartRanges({0.025 - kSkin, 0.025 - kSkin});
  ASSERT_TRUE(lists.update(row, traits));
  EXPECT_EQ(apartOf(0), std::vector<Index>{2});
  lists.setApartRanges({});
  // The first one is removed. No other particle has moved, but other pairs are apart.
  traits[0].ancestor = 4;
  lists.forget();
  ASSERT_TRUE(lists.update(row, traits));
  EXPECT_EQ(listOf(lists, 0), (std::vector<Index>{1, 2, 3, 4}));
}

TEST(NeighborList, ListsParticlesInOnePlace) { expectAllPairs(Points(500, Vec3(0.1, -0.2, 0.3))); }

TEST(NeighborList, FindsPairsAcrossEveryBorderOfCells) {
  // Pairs in all directions at just less and just more than the reach, at places of all kinds.
  std::mt19937 generator(4);
  for (double place : {0.0, 1.0, 1e3, 1e6}) {
    Points points;
    for (int k = 0; k < 200; ++k) {
      const Vec3 p = place * Vec3(1.0, -1.0, 1.0) + 50.0 * randomVector(generator);
      const Vec3 direction = randomVector(generator).normalized();
      points.push_back(p);
      points.push_back(p + (k % 2 ? 0.999 : 1.001) * (kRadius + kSkin) * direction);
    }
    expectAllPairs(points);
  }
}

TEST(NeighborList, FarFlungParticlesCostNothingAndAreStillFound) {
  Points points = randomPoints(200, 0.3);
  for (double far : {1e6, 1e12, 1e100, 1e300}) {
    points.emplace_back(far, -far, 0.0);
    points.emplace_back(-far, 0.0, 2.0 * far);
  }
  points.push_back(points.back());
  expectAllPairs(points);
}

TEST(NeighborList, RefusesPlacesThatAreNoneAndHeaps) {
  NeighborList lists(kRadius, kSkin);
  Points points = randomPoints(50, 0.3);
  points[7].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(lists.update(points));
  points[7].y() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(lists.update(points));
  points[7].y() = 0.0;
  EXPECT_TRUE(lists.update(points));
  const Index most = NeighborList::kMostNeighbors + 1;
  EXPECT_TRUE(lists.update(Points(most, Vec3::Zero())));
  EXPECT_FALSE(lists.update(Points(most + 1, Vec3::Zero())));
  EXPECT_FALSE(lists.update(Points(most + 1, Vec3::Zero())));  // and does not treat the list of the unchanged heap as valid
  EXPECT_TRUE(lists.update(points));
}

TEST(NeighborList, IsMadeAnewOnlyWhenPairsHaveMovedAgainstEachOtherByMoreThanTheSkin) {
  NeighborList lists(kRadius, kSkin);
  Points points = randomPoints(400, 0.4);
  lists.update(points);
  std::mt19937 generator(2);
  Index rebuilds = 1;
  for (int step = 0; step < 60; ++step) {
    for (Vec3& p : points) p += 0.1 * kSkin * randomVector(generator);
    ASSERT_TRUE(lists.update(points));
    for (Index i = 0; i < 400; ++i) {
      const std::vector<Index> listed = listOf(lists, i), near = findNear(points, i, kRadius);
      EXPECT_TRUE(std::includes(listed.begin(), listed.end(), near.begin(), near.end())) << step << " " << i;
    }
  }
  EXPECT_GT(lists.numRebuilds(), rebuilds);
  EXPECT_LT(lists.numRebuilds(), 40);
  rebuilds = lists.numRebuilds();
  points.pop_back();
  lists.update(points);
  EXPECT_EQ(lists.numRebuilds(), rebuilds + 1);
  lists.update(points);
  EXPECT_EQ(lists.numRebuilds(), rebuilds + 1);
}

// Pairs come nearer by the difference of their displacements, at most a skin where all move by half of it about their middle.
TEST(NeighborList, IsKeptWhileAllMoveTogetherOrSomeAreHeld) {
  NeighborList lists(kRadius, kSkin);
  Points points = randomPoints(400, 0.4);
  lists.update(points);
  const auto expectValid = [&](Index rebuilds) {
    ASSERT_TRUE(lists.update(points));
    EXPECT_EQ(lists.numRebuilds(), rebuilds);
    for (Index i = 0; i < 400; ++i) {
      const std::vector<Index> listed = listOf(lists, i), near = findNear(points, i, kRadius);
      EXPECT_TRUE(std::includes(listed.begin(), listed.end(), near.begin(), near.end())) << i;
    }
  };
  for (Vec3& p : points) p += 7.0 * kSkin * Vec3(0.6, -0.8, 0.3);
  expectValid(1);
  Points begin = points;
  for (Index i = 0; i < 400; ++i) points[i] = begin[i] + 0.99 * kSkin * (i % 2) * Vec3::UnitZ();
  expectValid(1);
  // One that was out of reach comes near.
  points[0] = points[1] + (kRadius + 1.01 * kSkin) * Vec3::UnitX();
  ASSERT_TRUE(lists.update(points));
  begin = points;
  const Index rebuilds = lists.numRebuilds();
  points[0] = begin[1] + 0.99 * kRadius * Vec3::UnitX();
  expectValid(rebuilds + 1);
}

// In a sheet neighbours stay neighbours, however it moves.
TEST(NeighborList, IsKeptWhileASheetSwingsAndStretches) {
  NeighborList lists(kRadius, kSkin);
  constexpr Index kRows = 40;
  Points begin;
  for (Index i = 0; i < kRows * kRows; ++i) begin.emplace_back(0.7 * kRadius * (i % kRows), 0.7 * kRadius * (i / kRows), 0.0);
  ASSERT_TRUE(lists.update(begin));
  for (int step = 1; step <= 5; ++step) {
    Points points = begin;
    for (Vec3& p : points) {
      const double angle = 0.03 * step * p.x() / kRadius;
      p = Vec3(p.x() * std::cos(angle), 1.005 * p.y(), p.x() * std::sin(angle));
    }
    ASSERT_TRUE(lists.update(points));
    EXPECT_EQ(lists.numRebuilds(), 1) << step;
    for (Index i = 0; i < kRows * kRows; i += 7)
      for (const Index j : findNear(points, i, kRadius)) ASSERT_TRUE(std::binary_search(lists.begin(i), lists.end(i), j));
  }
}

TEST(NeighborList, IsKeptWhileTwoGroupsOutOfReachMoveEachAsAWhole) {
  NeighborList lists(kRadius, kSkin);
  const Index n = 2000;  // two blocks
  Points points = randomPoints(n, 0.3);
  const auto move = [&](const Vec3& by, const Vec3& jitter) {
    std::mt19937 generator(9);
    for (Index i = 0; i < n; i += 2) points[i] += by + jitter.cwiseProduct(randomVector(generator));
  };
  const auto expectAll = [&] {
    for (Index i = 0; i < n; ++i)
      for (const Index j : findNear(points, i, kRadius))
        ASSERT_TRUE(std::binary_search(lists.begin(i), lists.end(i), j)) << i << " " << j;
  };
  ASSERT_TRUE(lists.update(points));
  // One half passes through the other.
  move(Vec3(0.0, 0.0, 0.2), Vec3::Zero());
  ASSERT_TRUE(lists.update(points));
  EXPECT_EQ(lists.numRebuilds(), 2);
  expectAll();
  // Out of reach it may move on, also as it deforms a little, or back and forth: lists are made anew only now and then.
  constexpr int kMoves = 24;
  for (int k = 0; k < kMoves; ++k) {
    move(Vec3(0.1, 0.3, k % 3 == 2 ? -0.4 : 0.7), 0.05 * kSkin * Vec3::Ones());
    ASSERT_TRUE(lists.update(points));
    expectAll();
  }
  const Index rebuilds = lists.numRebuilds();
  EXPECT_LT(rebuilds, 2 + kMoves / 2);
  // But not come back to another place.
  move(-Vec3(0.1 * kMoves, 0.3 * kMoves, kMoves / 3), Vec3::Zero());
  ASSERT_TRUE(lists.update(points));
  EXPECT_EQ(lists.numRebuilds(), rebuilds + 1);
  expectAll();
}

TEST(NeighborList, IsTheSameForEveryNumberOfThreads) {
  const Points points = randomPoints(5000, 0.7);
  std::vector<std::vector<Index>> first;
  for (int threads : {1, 2, 3}) {
    setNumThreads(threads);
    NeighborList lists(kRadius, kSkin);
    ASSERT_TRUE(lists.update(points));
    std::vector<std::vector<Index>> all;
    for (Index i = 0; i < 5000; ++i) all.push_back(listOf(lists, i));
    if (first.empty()) first = all;
    EXPECT_EQ(all, first) << threads;
  }
  setNumThreads(0);
}

}  // namespace
}  // namespace deformable_surface::test
