// Simplification keeps what a surface needs: even spacing, corners, straight edges, protected points, every part. It also ends on
// clouds that are no surface.
#include "deformable_surface/cloud/simplification.h"

#include "cloud/test_surfaces.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/rings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

namespace deformable_surface::cloud {
namespace {

constexpr Index kNeighbors = 10;

Simplification simplifyTo(const TestSurface& surface, Index min_points, const std::vector<Index>& protected_points = {}) {
  return simplify(surface.positions, surface.normals, kNeighbors, min_points, protected_points);
}

TestSurface select(const TestSurface& surface, const std::vector<Index>& points) {
  TestSurface selected;
  for (Index i : points) selected.add(surface.positions[i], surface.normals[i]);
  return selected;
}

// Standard deviation of the nearest distances over their mean.
double measureUnevenness(const TestSurface& surface) {
  const Lists nearest = nearestNeighbors(surface.positions, 1);
  double sum = 0.0, sum_of_squares = 0.0;
  for (Index i = 0; i < surface.size(); ++i) {
    const double distance = (surface.positions[*nearest.begin(i)] - surface.positions[i]).norm();
    sum += distance;
    sum_of_squares += distance * distance;
  }
  const double mean = sum / surface.size();
  return std::sqrt(sum_of_squares / surface.size() - mean * mean) / mean;
}

void expectSound(const TestSurface& surface, const Simplification& result) {
  EXPECT_EQ(result.num_points, surface.size());
  EXPECT_EQ(result.removed.size(), result.diameter.size());
  EXPECT_EQ(std::set<Index>(result.removed.begin(), result.removed.end()).size(), result.removed.size());
  EXPECT_TRUE(std::is_sorted(result.diameter.begin(), result.diameter.end()));
  for (double diameter : result.diameter) EXPECT_TRUE(std::isfinite(diameter));
}

TEST(Simplification, LeavesDebrisOutThatWouldTakeTheTarget) {
  TestSurface sheet = makeSheet(40);
  const Index num_sheet = sheet.size();
  const Lists near = nearestNeighbors(sheet.positions, 1);
  const double spacing = (sheet.positions[*near.begin(0)] - sheet.positions[0]).norm();
  constexpr Index kCrumbs = 60, kCrumb = 24;
  for (Index c = 0; c < kCrumbs; ++c)
    for (int k = 0; k < kCrumb; ++k)
      sheet.add(Vec3(40.0 * spacing * c + (k % 4) * spacing, (k / 4) * spacing, 50.0 * spacing), Vec3::UnitZ());
  const Lists neighbors = nearestNeighbors(sheet.positions, 2 * kNeighbors);
  const std::vector<char> no_corners(sheet.size(), 0);
  const auto keep = [&](Index target) {
    return simplify(sheet.positions, sheet.normals, kNeighbors, 10, {}, neighbors, no_corners, false, target);
  };
  const Simplification few = keep(100);
  EXPECT_EQ(few.num_left_out, kCrumbs);
  EXPECT_EQ(few.left_out.size(), static_cast<std::size_t>(kCrumb * kCrumbs));
  const std::vector<Index> kept = few.keepCount(100);
  EXPECT_EQ(kept.size(), 100u);
  EXPECT_TRUE(std::all_of(kept.begin(), kept.end(), [&](Index i) { return i < num_sheet; }));
  // With so many points wanted, a small part gets three points.
  EXPECT_EQ(keep(1500).num_left_out, 0);
  // Without a target no part is too small.
  EXPECT_EQ(keep(0).num_left_out, 0);
}

TEST(Simplification, EveryTargetAndThresholdIsAPrefixOfOnePass) {
  const TestSurface sheet = makeSheet(30, 0.2);
  const Simplification result = simplifyTo(sheet, 50);
  expectSound(sheet, result);
  EXPECT_EQ(result.removed.size(), 850u);
  EXPECT_EQ(result.keepCount(1000).size(), 900u);
  EXPECT_EQ(result.keepCount(0).size(), 50u);

  std::vector<Index> more = result.keepCount(400);
  const std::vector<Index> fewer = result.keepCount(200);
  EXPECT_EQ(more.size(), 400u);
  EXPECT_EQ(fewer.size(), 200u);
  EXPECT_TRUE(std::is_sorted(more.begin(), more.end()));
  EXPECT_TRUE(std::includes(more.begin(), more.end(), fewer.begin(), fewer.end()));

  const double threshold = result.diameter[500];
  const std::vector<Index> kept = result.keepDiameter(threshold);
  for (std::size_t r = 0; r < result.removed.size(); ++r) {
    EXPECT_EQ(std::binary_search(kept.begin(), kept.end(), result.removed[r]), result.diameter[r] >= threshold);
  }
  EXPECT_EQ(result.keepDiameter(0.0).size(), 900u);
  EXPECT_EQ(result.keepDiameter(std::numeric_limits<double>::infinity()).size(), 50u);

  // A pass that stops earlier gives the beginning of a pass that continues.
  const Simplification shorter = simplifyTo(sheet, 300);
  ASSERT_EQ(shorter.removed.size(), 600u);
  EXPECT_TRUE(std::equal(shorter.removed.begin(), shorter.removed.end(), result.removed.begin()));
}

// In larger clouds points are evaluated ahead of their turn, by all threads.
TEST(Simplification, DoesNotDependOnTheNumberOfThreads) {
  for (const TestSurface& surface : {makeTorus(90, 40, 0.0), makeTorus(120, 60, 0.0), makeSheet(100, 0.3)}) {
    const Lists neighbors = nearestNeighbors(surface.positions, 32);
    const std::vector<char> none(surface.positions.size(), 0);
    for (const bool over_surface : {false, true}) {
      const auto order = [&](int threads) {
        setNumThreads(threads);
        return simplify(surface.positions, surface.normals, 16, 100, {}, neighbors, none, over_surface);
      };
      const Simplification one = order(1), three = order(3);
      setNumThreads(0);
      EXPECT_EQ(one.removed, three.removed);
      EXPECT_EQ(one.diameter, three.diameter);
    }
  }
}

TEST(Simplification, KeyIsTheRingDiameterOfAHexagonalLattice) {
  TestSurface lattice;
  for (int i = 0; i < 30; ++i) {
    for (int j = 0; j < 30; ++j) lattice.add(Vec3(0.1 * (i + 0.5 * (j % 2)), 0.1 * std::sqrt(0.75) * j, 0.0), Vec3::UnitZ());
  }
  const Simplification result = simplifyTo(lattice, 850);
  EXPECT_NEAR(result.diameter.front(), 0.2, 1e-9);
}

TEST(Simplification, SpacesPointsEvenly) {
  for (double jitter : {0.0, 0.2, 0.45}) {
    const TestSurface sheet = makeSheet(70, jitter);
    EXPECT_LT(measureUnevenness(select(sheet, simplifyTo(sheet, 400).keepCount(400))), 0.22) << "jitter " << jitter;
  }
  const TestSurface sphere = makeSphere(5000);
  EXPECT_LT(measureUnevenness(select(sphere, simplifyTo(sphere, 400).keepCount(400))), 0.22);
}

TEST(Simplification, SheetKeepsItsCornersAndStraightEdges) {
  const int side = 40;
  for (double jitter : {0.0, 0.3}) {
    TestSurface sheet = makeSheet(side, jitter);
    sheet.rotate(makeRotation(0.5, 0.8));
    for (Index target : {400, 150, 60}) {
      const std::vector<Index> kept = simplifyTo(sheet, target).keepCount(target);
      ASSERT_EQ(static_cast<Index>(kept.size()), target);
      for (Index corner : {0, side - 1, side * (side - 1), side * side - 1}) {
        EXPECT_TRUE(std::binary_search(kept.begin(), kept.end(), corner)) << "target " << target << ", corner " << corner;
      }
      // No part of an edge is without points for longer than a few mean spacings, and the area is complete.
      const double spacing = 1.0 / std::sqrt(target);
      double last = 0.0;
      for (Index i : kept) {
        if (i % side != 0) continue;
        const double along = (sheet.positions[i] - sheet.positions[0]).norm();
        EXPECT_LT(along - last, 3.0 * spacing);
        last = along;
      }
      EXPECT_NEAR(last, 1.0, 1e-9);
      const TestSurface few = select(sheet, kept);
      const Rings rings = buildRings(few.positions, few.normals, nearestNeighbors(few.positions, 16));
      double area = 0.0;
      for (double share : rings.area) area += share;
      EXPECT_NEAR(area, 1.0, 0.02) << "target " << target;
      EXPECT_EQ(measureTopology(rings).euler_characteristic, 1);
    }
  }
}

TEST(Simplification, ClosedSurfacesKeepTheirTopology) {
  const TestSurface sphere = makeSphere(3000), torus = makeTorus(120, 50, 0.2);
  for (const auto& [surface, expected] : {std::pair<const TestSurface*, Index>(&sphere, 2), {&torus, 0}}) {
    const TestSurface few = select(*surface, simplifyTo(*surface, 400).keepCount(400));
    const Topology topology = measureTopology(buildRings(few.positions, few.normals, nearestNeighbors(few.positions, 16)));
    EXPECT_EQ(topology.components, 1);
    EXPECT_EQ(topology.boundary_loops, 0);
    EXPECT_EQ(topology.euler_characteristic, expected);
  }
}

TEST(Simplification, ProtectedPointsStay) {
  const TestSurface sheet = makeSheet(20, 0.2);
  const std::vector<Index> protected_points{0, 21, 22, 23, 42, 43, 200, 201, 202, 399, 200};
  const Simplification result = simplifyTo(sheet, 0, protected_points);
  for (Index i : protected_points) EXPECT_EQ(std::count(result.removed.begin(), result.removed.end(), i), 0) << i;
  EXPECT_GE(result.keepCount(0).size(), 12u);  // the ten protected, the two other corners
  EXPECT_LE(result.keepCount(0).size(), 12u);
}

TEST(Simplification, EveryPartKeepsPoints) {
  TestSurface surface = makeSheet(20, 0.2);
  surface.append(makeSphere(200), Vec3(10.0, 0.0, 0.0));
  surface.append(makeSheet(2), Vec3(-20.0, 0.0, 0.0));
  const Index isolated = surface.size();
  surface.add(Vec3(0.0, 50.0, 0.0), Vec3::UnitZ());
  const Simplification result = simplifyTo(surface, 0);
  expectSound(surface, result);
  const std::vector<Index> kept = result.keepCount(0);
  const auto countKept = [&](Index begin, Index end) {
    return std::lower_bound(kept.begin(), kept.end(), end) - std::lower_bound(kept.begin(), kept.end(), begin);
  };
  EXPECT_EQ(countKept(0, 400), 4);  // its corners
  EXPECT_EQ(countKept(400, 600), 3);
  EXPECT_GE(countKept(600, 604), 3);
  EXPECT_TRUE(std::binary_search(kept.begin(), kept.end(), isolated));
}

TEST(Simplification, CloseLayersAreThinnedOneByOne) {
  // Two layers closer to each other than the remaining points. The lower layer must be thinned as it would be without the upper
  // one.
  const TestSurface lower = makeSheet(30, 0.2);
  TestSurface both = lower;
  both.append(makeSheet(30, 0.2, 2), Vec3(0.0, 0.0, 0.2));
  const std::vector<Index> alone = simplifyTo(lower, 0).removed;
  std::vector<Index> together;
  for (Index i : simplifyTo(both, 0).removed) {
    if (i < lower.size()) together.push_back(i);
  }
  EXPECT_EQ(together, alone);
}

// As at the rims of gaps, where lists along the surface are short: all points ask for more neighbours, through the lists of each
// other.
TEST(Simplification, ListsThatAreTooShortAreFilledAlikeByAnyNumberOfThreads) {
  const TestSurface sheet = makeSheet(120, 0.2);
  const Lists neighbors = nearestNeighbors(sheet.positions, kNeighbors - 2);
  std::vector<Simplification> results;
  for (const int threads : {1, 2, 3}) {
    setNumThreads(threads);
    results.push_back(
        simplify(sheet.positions, sheet.normals, kNeighbors, 1000, {}, neighbors, std::vector<char>(sheet.size(), 0), true));
  }
  setNumThreads(0);
  expectSound(sheet, results[0]);
  for (const Simplification& result : results) {
    EXPECT_EQ(result.removed, results[0].removed);
    EXPECT_EQ(result.diameter, results[0].diameter);
  }
}

// Half of the mean spacing at the left edge of a sheet, one and a half of it at the right.
std::vector<double> wantMoreAtTheLeft(const TestSurface& sheet) {
  std::vector<double> wanted;
  for (const Vec3& p : sheet.positions) wanted.push_back(0.5 + p.x());
  return wanted;
}

Simplification simplifyGraded(const TestSurface& surface, Index min_points, const std::vector<double>& wanted, Index target = 0) {
  const Lists neighbors = nearestNeighbors(surface.positions, 2 * kNeighbors);
  const std::vector<char> is_corner = findBoundary(surface.positions, surface.normals, neighbors, kNeighbors).is_corner;
  return simplify(surface.positions, surface.normals, kNeighbors, min_points, {}, neighbors, is_corner, false, target, wanted);
}

// Standard deviation of the nearest distances, each over what is wanted there, over their mean.
double measureUnevenness(const TestSurface& sheet, const std::vector<Index>& kept, const std::vector<double>& wanted) {
  const TestSurface few = select(sheet, kept);
  const Lists nearest = nearestNeighbors(few.positions, 1);
  double sum = 0.0, sum_of_squares = 0.0;
  for (Index i = 0; i < few.size(); ++i) {
    const double distance = (few.positions[*nearest.begin(i)] - few.positions[i]).norm() / wanted[kept[i]];
    sum += distance;
    sum_of_squares += distance * distance;
  }
  const double mean = sum / few.size();
  return std::sqrt(sum_of_squares / few.size() - mean * mean) / mean;
}

TEST(Simplification, SpacesPointsAsWanted) {
  const TestSurface sheet = makeSheet(70, 0.3);
  const std::vector<double> wanted = wantMoreAtTheLeft(sheet);
  const Simplification result = simplifyGraded(sheet, 50, wanted);
  expectSound(sheet, result);
  std::vector<Index> finer;
  for (const Index count : {800, 400, 200}) {
    const std::vector<Index> kept = result.keepCount(count);
    ASSERT_EQ(static_cast<Index>(kept.size()), count);
    // Every coarser set is graded in the same way, and a part of the finer ones.
    EXPECT_LT(measureUnevenness(sheet, kept, wanted), 0.22) << count;
    if (!finer.empty()) {
      EXPECT_TRUE(std::includes(finer.begin(), finer.end(), kept.begin(), kept.end()));
    }
    finer = kept;
  }
  setNumThreads(3);
  const Simplification again = simplifyGraded(sheet, 50, wanted);
  setNumThreads(0);
  EXPECT_EQ(result.removed, again.removed);
  EXPECT_EQ(result.diameter, again.diameter);
}

TEST(Simplification, TheSameSpacingWantedEverywhereIsEvenSpacingToTheBit) {
  const TestSurface sheet = makeSheet(40, 0.3);
  const Simplification even = simplifyTo(sheet, 100);
  const Simplification same = simplifyGraded(sheet, 100, std::vector<double>(sheet.size(), 1.0));
  EXPECT_EQ(even.removed, same.removed);
  EXPECT_EQ(even.diameter, same.diameter);
}

TEST(Simplification, ALargeCloudIsSpacedAsWantedFromTheCountThatIsAskedFor) {
  const TestSurface sheet = makeSheet(500, 0.3);
  std::vector<double> wanted;
  for (const Vec3& p : sheet.positions) wanted.push_back(0.8 + 0.4 * p.x());
  const Simplification result = simplifyGraded(sheet, 500, wanted);
  EXPECT_EQ(result.keepCount(0).size(), 500u);
  EXPECT_LT(measureUnevenness(sheet, result.keepCount(500), wanted), 0.22);
  // More than a quarter of the points that remain for the rings; the number of rings changes with it.
  const std::vector<Index> many = simplifyGraded(sheet, 5000, wanted, 5000).keepCount(5000);
  ASSERT_EQ(many.size(), 5000u);
  EXPECT_LT(measureUnevenness(sheet, many, wanted), 0.22);
}

// With so many points most are removed by distance alone, before rings are computed.
TEST(Simplification, ALargeCloudIsThinnedAsEvenlyAsASmallOneInOneOrderForAnyNumberOfThreads) {
  const TestSurface sheet = makeSheet(400, 0.3);
  setNumThreads(1);
  const Simplification result = simplifyTo(sheet, 500);
  setNumThreads(3);
  const Simplification again = simplifyTo(sheet, 500);
  setNumThreads(0);
  expectSound(sheet, result);
  EXPECT_EQ(result.removed, again.removed);
  EXPECT_EQ(result.diameter, again.diameter);
  EXPECT_EQ(result.keepCount(0).size(), 500u);
  // As even as small clouds (SpacesPointsEvenly), whether the count is reached by rings or by distances.
  for (const Index count : {500, 20000, 100000})
    EXPECT_LT(measureUnevenness(select(sheet, result.keepCount(count))), 0.2) << count;
  const std::vector<Index> kept = result.keepCount(500);
  for (const Index corner : {0, 399, 399 * 400, 400 * 400 - 1})
    EXPECT_TRUE(std::binary_search(kept.begin(), kept.end(), corner)) << corner;
}

// Two sheets a spacing apart, and a clump too small to be thinned by distances.
TEST(Simplification, PartsOfALargeCloudStayApart) {
  TestSurface layers = makeSheet(290, 0.2, 1);
  const double spacing = 1.0 / 289.0;
  const TestSurface other = makeSheet(290, 0.2, 2);
  for (Index i = 0; i < other.size(); ++i) layers.add(other.positions[i] + Vec3(0.0, 0.0, 3.0 * spacing), other.normals[i]);
  const Index first_of_clump = layers.size();
  const TestSurface clump = makeSheet(6, 0.2, 3);
  for (Index i = 0; i < clump.size(); ++i) layers.add(1e-3 * clump.positions[i] + Vec3(3.0, 0.0, 0.0), clump.normals[i]);
  const Simplification result = simplifyTo(layers, 400);
  expectSound(layers, result);
  const std::vector<Index> kept = result.keepCount(400);
  const auto countBetween = [&](Index begin, Index end) {
    return std::lower_bound(kept.begin(), kept.end(), end) - std::lower_bound(kept.begin(), kept.end(), begin);
  };
  EXPECT_GE(countBetween(first_of_clump, layers.size()), 3);
  const auto below = countBetween(0, other.size()), above = countBetween(other.size(), first_of_clump);
  EXPECT_GT(below, 150);
  EXPECT_GT(above, 150);
  // Each sheet is even by itself, so neither was thinned because of the other.
  std::vector<Index> lower(kept.begin(), kept.begin() + below);
  EXPECT_LT(measureUnevenness(select(layers, lower)), 0.25);
}

TEST(Simplification, EndsOnCloudsThatAreNoSurface) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto randomVector = [&] { return Vec3(normal(random), normal(random), normal(random)); };

  TestSurface line, circle, sliver, hair, volume, one, none;
  for (int i = 0; i < 100; ++i) {
    line.add(Vec3(0.01 * i, 0.02 * i, 0.0), Vec3::UnitZ());
    circle.add(Vec3(std::cos(0.02 * kPi * i), std::sin(0.02 * kPi * i), 0.0), Vec3::UnitZ());
  }
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) sliver.add(Vec3(1e-7 * i, j, 0.0), Vec3::UnitZ());
  }
  hair = makeSheet(15, 0.1);
  for (int i = 1; i < 40; ++i) hair.add(Vec3(0.5, 0.5, 0.05 * i), Vec3::UnitX());
  for (int i = 0; i < 600; ++i) volume.add(randomVector(), randomVector());
  one.add(Vec3::Zero(), Vec3::UnitZ());

  for (const TestSurface* surface : {&line, &circle, &sliver, &hair, &volume, &one, &none}) {
    for (Index min_points : {0, 30}) {
      const Simplification result = simplifyTo(*surface, min_points);
      expectSound(*surface, result);
      EXPECT_GE(result.keepCount(0).size(), std::min<std::size_t>(surface->size(), std::max(3, min_points)));
    }
  }
  // A curve is thinned evenly, too. The ends of the line stay.
  const std::vector<Index> of_line = simplifyTo(line, 12).keepCount(12);
  ASSERT_EQ(of_line.size(), 12u);
  EXPECT_EQ(of_line.front(), 0);
  EXPECT_EQ(of_line.back(), 99);
  EXPECT_EQ(simplifyTo(circle, 12).keepCount(12).size(), 12u);
  EXPECT_LT(measureUnevenness(select(circle, simplifyTo(circle, 12).keepCount(12))), 0.5);
}

TEST(Simplification, BadArgumentsAreRefused) {
  TestSurface sheet = makeSheet(5);
  EXPECT_THROW(simplify(sheet.positions, sheet.normals, 2, 10, {}), InputError);
  EXPECT_THROW(simplify(sheet.positions, sheet.normals, 10, -1, {}), InputError);
  EXPECT_THROW(simplifyGraded(sheet, 10, std::vector<double>(24, 1.0)), InputError);
  for (const double spacing : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(simplifyGraded(sheet, 10, std::vector<double>(25, spacing)), InputError) << spacing;
  EXPECT_THROW(simplify(sheet.positions, sheet.normals, 10, 10, {25}), InputError);
  EXPECT_THROW(simplify(sheet.positions, sheet.normals, 10, 10, {-1}), InputError);
  sheet.normals.pop_back();
  EXPECT_THROW(simplify(sheet.positions, sheet.normals, 10, 10, {}), InputError);
}

}  // namespace
}  // namespace deformable_surface::cloud
