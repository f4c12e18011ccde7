// Points that are close in space but far apart along the surface are not linked. Points that are close along it are.
#include "deformable_surface/cloud/geodesics.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/geodesic_cells.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/normals.h"
#include "deformable_surface/cloud/rings.h"
#include "deformable_surface/cloud/simplification.h"
#include "support/gaps.h"
#include "support/shared_data.h"
#include "test_surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>

namespace deformable_surface::cloud {
namespace {

using test::Coupling;
using test::Gapped;
using test::makeFold;
using test::makeLegs;
using test::makeStack;
using test::makeTwoBars;
using test::measureCoupling;

constexpr Index kListed = 32;  // twice the default k, as in a set-up

// The limits that docs/geodesics.md states.
constexpr double kLeastWithin = 0.95, kMostAcross = 0.02;

Lists findWithin(const Points& points, double radius) {
  const KdTree tree(points);
  std::vector<Neighbor> found;
  Lists lists;
  for (Index i = 0; i < tree.size(); ++i) {
    tree.withinRadius(points[i], radius, found);
    for (const Neighbor& other : found)
      if (other.index != i) lists.items.push_back(other.index);
    lists.offsets.push_back(static_cast<Index>(lists.items.size()));
  }
  return lists;
}

Coupling couple(const Gapped& cloud, const Lists& links, const SurfaceSides& sides,
                const OrAuto<double>& geodesic_exponent = {}) {
  const GeodesicGraph graph = buildGeodesicGraph(cloud.positions, sides, links, geodesic_exponent);
  return measureCoupling(cloud, links, geodesicWeights(graph, cloud.positions, links));
}

SurfaceSides estimateSides(const Points& positions) {
  return {estimateNormals(positions, nearestNeighbors(positions, kListed)), false};
}

TEST(Geodesics, BarsOneAndAHalfSpacingsApartAreToldApartWithAndWithoutJitter) {
  for (double jitter : {0.0, 0.1, 0.2}) {
    for (double gap : {1.5, 2.0, 2.5}) {
      const Gapped bars = makeTwoBars(gap, jitter);
      for (const SurfaceSides& sides : {SurfaceSides(), SurfaceSides{bars.normals, false}}) {
        const Coupling coupling = couple(bars, findWithin(bars.positions, 3.0), sides);
        EXPECT_GE(coupling.within, kLeastWithin) << "gap " << gap << ", jitter " << jitter;
        EXPECT_LE(coupling.across, kMostAcross) << "gap " << gap << ", jitter " << jitter;
      }
    }
  }
}

TEST(Geodesics, ThickBarsOneAndAHalfSpacingsApartAreToldApart) {
  for (double jitter : {0.0, 0.2}) {
    const Gapped bars = makeTwoBars(1.5, jitter, 3);
    const Coupling coupling = couple(bars, findWithin(bars.positions, 3.0), {});
    EXPECT_GE(coupling.within, kLeastWithin) << "jitter " << jitter;
    EXPECT_LE(coupling.across, kMostAcross) << "jitter " << jitter;
  }
}

TEST(Geodesics, ANarrowingGapIsBridgedStepByStep) {
  double last = 0.0;
  double largest_step = 0.0;
  for (double gap = 1.7; gap > 0.95; gap -= 0.05) {
    double across = 0.0;
    for (unsigned seed : {1u, 2u}) {
      const Gapped bars = makeTwoBars(gap, 0.2, 1, seed);
      across += 0.5 * couple(bars, findWithin(bars.positions, 3.0), {}).across;
    }
    // Another gap width gives another cloud: pairs enter and leave the radius. This changes a few per cent.
    EXPECT_GE(across, last - 0.03) << "gap " << gap;
    largest_step = std::max(largest_step, across - last);
    last = across;
  }
  EXPECT_GT(last, 0.9);
  EXPECT_LT(largest_step, 0.4) << "a twentieth of the spacing must not decide between apart and together";
}

TEST(Geodesics, SheetsHalfASpacingApartAreToldApartByTheirNormals) {
  for (double jitter : {0.0, 0.2}) {
    const Gapped stack = makeStack(2, 0.5, jitter, false);
    const Lists links = nearestNeighbors(stack.positions, kListed);
    const SurfaceSides estimated = estimateSides(stack.positions);
    const Coupling coupling = couple(stack, links, estimated);
    EXPECT_GE(coupling.within, kLeastWithin) << "jitter " << jitter;
    EXPECT_LE(coupling.across, kMostAcross) << "jitter " << jitter;
    EXPECT_GT(couple(stack, links, {}).across, 0.5) << "without normals nothing could tell";
  }
}

TEST(Geodesics, SidesOfAThinBodyAreToldApartByOrientedNormalsAtATenthOfTheSpacing) {
  const Gapped body = makeStack(2, 0.1, 0.1, true);
  const Lists links = nearestNeighbors(body.positions, kListed);
  const Coupling coupling = couple(body, links, {body.normals, true});
  EXPECT_GE(coupling.within, kLeastWithin);
  EXPECT_LE(coupling.across, kMostAcross);
  EXPECT_GT(couple(body, links, {body.normals, false}).across, 0.5);
}

// Where the legs are closest, their normals are opposite. Beside that place the normals differ by less, and the gap is still no
// wider than the spacing along the legs. That spacing alone costs true links some weight. A link there has no part along the mean
// normal.
TEST(Geodesics, RoundLegsAreToldApartBesideWhereTheyAreNearestToo) {
  constexpr double kRadius = 5.0, kAlong = 3.0, kLeastAlongSparse = 0.92;
  for (const double gap : {0.5, 0.75, 1.0, 1.5}) {
    const Gapped legs = makeLegs(kRadius, kAlong, gap, 0.2);
    const Coupling coupling = couple(legs, nearestNeighbors(legs.positions, kListed), {legs.normals, true});
    EXPECT_GE(coupling.within, kLeastAlongSparse) << "gap " << gap;
    EXPECT_LE(coupling.across, kMostAcross) << "gap " << gap;
  }
}

// An annulus of radii 6 and 10 with a slit along +x: at its corners few points see the other side, by lists that reach far.
Points makeSlitAnnulus(double spacing, double slit, double jitter, unsigned seed) {
  std::mt19937 random(seed);
  const auto draw = [&] { return jitter * spacing * (2.0 * random() / 4294967295.0 - 1.0); };
  Points points;
  const int n = static_cast<int>(std::lround(10.0 / spacing));
  for (int row = -n; row <= n; ++row)
    for (int column = -n; column <= n; ++column) {
      const Vec3 p(column * spacing + draw(), row * spacing + draw(), 0.0);
      const bool is_in_slit = p.x() > 0.0 && std::abs(p.y()) < 0.5 * slit;
      if (p.norm() >= 6.0 && p.norm() <= 10.0 && !is_in_slit) points.push_back(p);
    }
  return points;
}

TEST(Geodesics, TheCornersOfASlitAreNotGlued) {
  for (const double spacing : {0.4, 0.5})
    for (const double slit : {1.2, 2.0, 2.6})
      for (unsigned seed = 0; seed < 4; ++seed) {
        const double jitter = seed == 0 ? 0.0 : 0.2;
        const Points points = makeSlitAnnulus(spacing, slit, jitter, seed);
        const Lists near = nearestNeighbors(points, kListed);
        const Lists kept = keepGeodesicNeighbors(buildGeodesicGraph(points, {}, near, {}), points, {}, near).lists;
        std::vector<Index> all(points.size());
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Index>(i);
        const Lists cells = findGeodesicCells(points, kept, all, kListed / 2).neighbors;
        for (const Lists& lists : {kept, cells})
          for (Index i = 0; i < lists.size(); ++i)
            for (const Index* j = lists.begin(i); j != lists.end(i); ++j)
              ASSERT_FALSE(points[i].x() > 0.0 && points[*j].x() > 0.0 && points[i].y() * points[*j].y() < 0.0)
                  << spacing << " " << slit << " " << seed << ": " << points[i].transpose() << " to " << points[*j].transpose();
      }
}

// Legs sampled more sparsely along than around. Links across the gap beside the closest place are counted; links at the closest
// place must not exist.
TEST(Geodesics, WhatSticksAcrossAGapIsCountedAndNothingElse) {
  const auto count = [](const Gapped& cloud) {
    const Lists links = nearestNeighbors(cloud.positions, kListed);
    const SurfaceSides sides{cloud.normals, true};
    return keepGeodesicNeighbors(buildGeodesicGraph(cloud.positions, sides, links, {}), cloud.positions, sides, links).num_joined;
  };
  for (const double gap : {0.2, 0.33}) {
    EXPECT_GT(count(makeLegs(2.0, 3.0, gap, 0.0)), 10) << gap;
    EXPECT_GT(count(makeLegs(2.0, 3.0, gap, 0.2)), 10) << gap;
    for (const double radius : {2.0, 5.0})
      for (const double jitter : {0.0, 0.2}) EXPECT_EQ(count(makeLegs(radius, 1.0, gap, jitter)), 0) << gap;
  }
  // The two sides of a thin body, or the leaves of a stack, do not count as facing each other.
  EXPECT_EQ(count(makeStack(2, 0.5, 0.1, true)), 0);
}

TEST(Geodesics, NormalsFlippedAtRandomDoNoHarm) {
  const TestSurface sheet = makeSheet(40, 0.2);
  const Lists links = nearestNeighbors(sheet.positions, kListed);
  std::mt19937 random(1);
  SurfaceSides flipped{sheet.normals, true};
  for (Vec3& normal : flipped.normals)
    if (random() & 1u) normal = -normal;
  const auto weigh = [&](const SurfaceSides& sides) {
    return geodesicWeights(buildGeodesicGraph(sheet.positions, sides, links, {}), sheet.positions, links);
  };
  const std::vector<double> found = weigh(flipped), expected = weigh({sheet.normals, true});
  for (std::size_t e = 0; e < found.size(); ++e) ASSERT_NEAR(found[e], expected[e], 1e-9);
}

TEST(Geodesics, LeavesOfAFoldedSheetAreToldApartAndItsBendHolds) {
  const Gapped fold = makeFold(1.5, 0.1);
  const Lists links = nearestNeighbors(fold.positions, kListed);
  const GeodesicGraph graph = buildGeodesicGraph(fold.positions, {fold.normals, false}, links, {});
  const Coupling coupling = measureCoupling(fold, links, geodesicWeights(graph, fold.positions, links));
  EXPECT_GE(coupling.within, kLeastWithin);
  EXPECT_LE(coupling.across, kMostAcross);
  Index components = 0;
  labelComponents(
      buildRings(fold.positions, fold.normals, keepGeodesicNeighbors(graph, fold.positions, {fold.normals, false}, links).lists),
      components);
  EXPECT_EQ(components, 1);
}

// A sheet of 40 x 24 points with one crease (rad), a part of the spacing from a row. The spacing is 1.
struct Creased {
  Points positions, normals;
};
Creased makeCreased(double angle, double offset, double jitter) {
  Creased sheet;
  std::mt19937 random(7);
  const auto draw = [&] { return jitter * (2.0 * random() / 4294967296.0 - 1.0); };
  for (Index i = -20; i < 20; ++i)
    for (Index j = 0; j < 24; ++j) {
      const double along = i + offset + draw(), across = j + draw();
      const double turn = along < 0.0 ? 0.0 : angle;
      sheet.positions.push_back({along * std::cos(turn), across, along * std::sin(turn)});
      sheet.normals.push_back({-std::sin(turn), 0.0, std::cos(turn)});
    }
  return sheet;
}

// The number of points that the lists connect with the first.
Index countReached(const Lists& lists) {
  std::vector<char> is_reached(lists.size());
  std::vector<Index> open{0};
  is_reached[0] = 1;
  Index count = 0;
  while (!open.empty()) {
    const Index i = open.back();
    open.pop_back();
    ++count;
    for (const Index* j = lists.begin(i); j != lists.end(i); ++j) {
      if (is_reached[*j]) continue;
      is_reached[*j] = 1;
      open.push_back(*j);
    }
  }
  return count;
}

TEST(Geodesics, ACreaseDoesNotDivideASheet) {
  const auto countConnected = [](const Points& positions, const SurfaceSides& sides) {
    const Lists in_space = nearestNeighbors(positions, kListed);
    return countReached(
        keepGeodesicNeighbors(buildGeodesicGraph(positions, sides, in_space, {}), positions, sides, in_space).lists);
  };
  for (const double degrees : {40.0, 60.0, 75.0, 80.0, 85.0, 100.0, 120.0, 150.0})
    for (const double offset : {0.0, 0.2, 0.25, 0.3, 0.5, 0.75})
      for (const double jitter : {0.0, 0.1}) {
        const Creased sheet = makeCreased(degrees * kPi / 180.0, offset, jitter);
        const Index n = static_cast<Index>(sheet.positions.size());
        NormalsInSpace found = estimateNormalsInSpace(sheet.positions, nearestNeighbors(sheet.positions, kListed));
        EXPECT_EQ(n, countConnected(sheet.positions, {found.normals, false, found.at_creases}))
            << degrees << ' ' << offset << ' ' << jitter;
        // Leaves that face each other more steeply are parts for normals that have sides.
        if (degrees <= 100.0) {
          EXPECT_EQ(n, countConnected(sheet.positions, {sheet.normals, true})) << degrees << ' ' << offset << ' ' << jitter;
        }
      }
}

TEST(Geodesics, ListsOfSurfacesWithoutGapsStayAsTheyAre) {
  for (const TestSurface& surface : {makeSheet(40), makeSheet(40, 0.1), makeSphere(2000), makeTorus(80, 32, 0.1), makeDisc(20)}) {
    const Lists links = nearestNeighbors(surface.positions, kListed);
    const SurfaceSides sides{estimateNormals(surface.positions, links), false};
    const GeodesicNeighbors kept =
        keepGeodesicNeighbors(buildGeodesicGraph(surface.positions, sides, links, {}), surface.positions, sides, links);
    EXPECT_EQ(kept.num_refused, 0);
    EXPECT_EQ(kept.lists.items, links.items);
    EXPECT_EQ(kept.margin, kNoLimit);
  }
}

// A grid whose points are moved by a share of the spacing in its plane and by noise (standard deviation) across it, as in scans.
Gapped makeRoughSheet(double share, double noise) {
  constexpr int kSide = 50;
  Gapped sheet;
  test::Jitter jitter(share, 1), bump(1.0, 2);
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      double height = 0.0;  // of twelve uniform numbers: their sum has a deviation of two
      for (int draw = 0; draw < 12; ++draw) height += bump.draw();
      const double x = i + jitter.draw(), y = j + jitter.draw();
      sheet.add(Vec3(x, y, 0.5 * noise * height), Vec3::UnitZ(), 0, true);
    }
  }
  return sheet;
}

TEST(Geodesics, RoughAndUnevenSamplingsKeepTheirLinks) {
  for (double noise : {0.0, 0.1, 0.2}) {
    for (double jitter : {0.3, 0.5}) {
      const Gapped sheet = makeRoughSheet(jitter, noise);
      const Lists links = nearestNeighbors(sheet.positions, kListed);
      const Coupling coupling = couple(sheet, links, estimateSides(sheet.positions));
      EXPECT_GE(coupling.within, kLeastWithin) << "jitter " << jitter << ", noise " << noise;
    }
  }
}

TEST(Geodesics, AFewPointsInASparseSpotOfADenseSheetAreNoGap) {
  // The surroundings have links half as long as those at this place.
  constexpr int kSide = 48;
  Points points;
  test::Jitter jitter(0.1, 1);
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const bool is_sparse = std::abs(i - kSide / 2) <= 2 && std::abs(j - kSide / 2) <= 2;
      if (!is_sparse || (i % 2 == 0 && j % 2 == 0)) points.emplace_back(i + jitter.draw(), j + jitter.draw(), 0.0);
    }
  }
  const Lists links = nearestNeighbors(points, kListed);
  const SurfaceSides sides = estimateSides(points);
  const GeodesicNeighbors kept = keepGeodesicNeighbors(buildGeodesicGraph(points, sides, links, {}), points, sides, links);
  EXPECT_EQ(kept.num_refused, 0);
  EXPECT_EQ(kept.margin, kNoLimit);
}

// Two bars beside each other, their neighbours in space and over the surface.
struct KeptBars {
  Gapped bars;
  Lists links;
  GeodesicNeighbors kept;
};

KeptBars keepTwoBars() {
  Gapped bars = makeTwoBars(2.0, 0.1);
  Lists links = nearestNeighbors(bars.positions, kListed);
  const SurfaceSides sides{bars.normals, false};
  GeodesicNeighbors kept =
      keepGeodesicNeighbors(buildGeodesicGraph(bars.positions, sides, links, {}), bars.positions, sides, links);
  return {std::move(bars), std::move(links), std::move(kept)};
}

TEST(Geodesics, ListsAtAGapAreFilledFromTheirOwnSide) {
  const auto [bars, links, kept] = keepTwoBars();
  Index across = 0;
  for (Index i = 0; i < kept.lists.size(); ++i) {
    EXPECT_EQ(kept.lists.count(i), kListed);
    for (const Index* j = kept.lists.begin(i); j != kept.lists.end(i); ++j) {
      across += bars.is_asked[i] && bars.is_asked[*j] && bars.part[i] != bars.part[*j];
    }
  }
  EXPECT_EQ(across, 0);
  EXPECT_GT(kept.num_refused, 0);
}

TEST(Geodesics, ListsThatDoNotChangeAreTold) {
  const auto [bars, links, kept] = keepTwoBars();
  ASSERT_EQ(kept.lists.size(), static_cast<Index>(kept.is_changed.size()));
  Index num_other = 0;
  for (Index i = 0; i < kept.lists.size(); ++i) {
    const bool is_same = std::equal(links.begin(i), links.end(i), kept.lists.begin(i), kept.lists.end(i));
    num_other += !is_same;
    EXPECT_TRUE(is_same || kept.is_changed[i]) << i;
  }
  EXPECT_GT(num_other, 0);
  EXPECT_LT(std::count(kept.is_changed.begin(), kept.is_changed.end(), 1), kept.lists.size());
}

TEST(Geodesics, MarginGrowsWithTheGap) {
  double last = 0.0;
  for (double gap : {1.5, 2.0, 2.5}) {
    const Gapped bars = makeTwoBars(gap, 0.1);
    const Lists links = nearestNeighbors(bars.positions, kListed);
    const SurfaceSides sides{bars.normals, false};
    const double margin =
        keepGeodesicNeighbors(buildGeodesicGraph(bars.positions, sides, links, {}), bars.positions, sides, links).margin;
    EXPECT_GT(margin, last + 0.2) << "gap " << gap;
    EXPECT_LT(margin, gap) << "the trust radius is above the spacing";
    last = margin;
  }
}

TEST(Geodesics, UnitsDoNotMatter) {
  const Gapped bars = makeTwoBars(1.5, 0.2);
  Points millimetres = bars.positions;
  for (Vec3& p : millimetres) p *= 1000.0;
  const Lists links = nearestNeighbors(bars.positions, kListed);
  for (const OrAuto<double>& geodesic_exponent : {OrAuto<double>(), OrAuto<double>(15.0), OrAuto<double>(60.0)}) {
    const std::vector<double> in_metres =
        geodesicWeights(buildGeodesicGraph(bars.positions, {}, links, geodesic_exponent), bars.positions, links);
    const std::vector<double> in_millimetres =
        geodesicWeights(buildGeodesicGraph(millimetres, {}, links, geodesic_exponent), millimetres, links);
    // Weights change by about one per unit of detour. The trust radii are computed from float lengths.
    for (std::size_t e = 0; e < in_metres.size(); ++e) ASSERT_NEAR(in_metres[e], in_millimetres[e], 1e-5);
  }
}

TEST(Geodesics, AnExponentOfSixtyNeitherUnderflowsNorOverflows) {
  // A chain of short links around a gap, one jump across: sixty powers of a micrometre are 1e-360.
  Points points;
  for (int i = 0; i <= 10; ++i) points.emplace_back(1e-6 * i, 0.0, 0.0);
  for (int i = 1; i <= 2; ++i) points.emplace_back(1e-5, 1e-6 * i, 0.0);
  for (int i = 10; i >= 0; --i) points.emplace_back(1e-6 * i, 3e-6, 0.0);
  const Index last = static_cast<Index>(points.size()) - 1;
  const Lists links = findWithin(points, 3.5e-6);
  const GeodesicGraph graph = buildGeodesicGraph(points, {}, links, 60.0);
  const std::vector<double> distance = findGeodesicDistances(graph, points, links);
  Index asked = 0;
  for (Index e = links.offsets[0]; e < links.offsets[1]; ++e) {
    if (links.items[e] == last) {
      EXPECT_NEAR(distance[e], 23e-6, 1e-12) << "the way round, hop by hop";
      ++asked;
    }
    if (links.items[e] == 3) {
      EXPECT_NEAR(distance[e], 3e-6, 1e-12);
      ++asked;
    }
  }
  EXPECT_EQ(asked, 2);
}

TEST(Geodesics, AnExponentOfOneGivesEuclideanDistances) {
  const Gapped bars = makeTwoBars(1.5, 0.2);
  const Lists links = nearestNeighbors(bars.positions, kListed);
  const std::vector<double> distance =
      findGeodesicDistances(buildGeodesicGraph(bars.positions, {}, links, 1.0), bars.positions, links);
  for (Index i = 0; i < links.size(); ++i) {
    for (Index e = links.offsets[i]; e < links.offsets[i + 1]; ++e) {
      ASSERT_NEAR(distance[e], (bars.positions[links.items[e]] - bars.positions[i]).norm(), 1e-12);
    }
  }
}

TEST(Geodesics, DistancesAreThoseOfAllPathsOverTheGraph) {
  // Floyd's algorithm on the graph's costs.
  const Gapped bars = makeTwoBars(1.25, 0.2);
  const Index n = 120;
  const Points points(bars.positions.begin(), bars.positions.begin() + n);
  const Lists links = nearestNeighbors(points, 12);
  const GeodesicGraph graph = buildGeodesicGraph(points, {}, links, {});
  std::vector<double> all(n * n, kNoLimit);
  for (Index i = 0; i < n; ++i) {
    all[i * n + i] = 0.0;
    for (Index e = graph.links.offsets[i]; e < graph.links.offsets[i + 1]; ++e) all[i * n + graph.links.items[e]] = graph.cost[e];
  }
  for (Index m = 0; m < n; ++m)
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < n; ++j) all[i * n + j] = std::min(all[i * n + j], all[i * n + m] + all[m * n + j]);
  const std::vector<double> distance = findGeodesicDistances(graph, points, links);
  for (Index i = 0; i < n; ++i)
    for (Index e = links.offsets[i]; e < links.offsets[i + 1]; ++e)
      ASSERT_NEAR(distance[e], all[i * n + links.items[e]], 1e-12 * distance[e]);
}

TEST(Geodesics, EveryNumberOfThreadsGivesTheSameBits) {
  const Gapped bars = makeTwoBars(1.4, 0.3, 3);
  const auto run = [&](int threads) {
    setNumThreads(threads);
    const Lists links = nearestNeighbors(bars.positions, kListed);
    const SurfaceSides sides{estimateNormals(bars.positions, links), false};
    const GeodesicGraph graph = buildGeodesicGraph(bars.positions, sides, links, {});
    const GeodesicNeighbors kept = keepGeodesicNeighbors(graph, bars.positions, sides, links);
    const std::vector<double> weight = geodesicWeights(graph, bars.positions, links);
    setNumThreads(0);
    return std::make_tuple(graph.links.items, graph.cost, weight, kept.lists.items, kept.margin);
  };
  EXPECT_EQ(run(1), run(2));
  EXPECT_EQ(run(1), run(5));
}

TEST(Geodesics, WeightsFallSmoothlyFromOneToNothing) {
  EXPECT_EQ(weighDetour(1.0), 1.0);
  EXPECT_EQ(weighDetour(kFreeDetour), 1.0);
  EXPECT_NEAR(weighDetour(kKeptDetour), 0.5, 1e-15);
  EXPECT_EQ(weighDetour(kLongestDetour), 0.0);
  EXPECT_EQ(weighDetour(kNoLimit), 0.0);
}

TEST(Geodesics, WrongSizesAndExponentsAreRefused) {
  const TestSurface sheet = makeSheet(5);
  const Lists links = nearestNeighbors(sheet.positions, 8);
  EXPECT_THROW(buildGeodesicGraph(sheet.positions, {Points(3, Vec3::UnitZ()), false}, links, {}), InputError);
  EXPECT_THROW(buildGeodesicGraph(sheet.positions, {}, links, 0.5), InputError);
  EXPECT_THROW(buildGeodesicGraph(sheet.positions, {}, links, std::nan("")), InputError);
  EXPECT_THROW(findGeodesicDistances(GeodesicGraph(), sheet.positions, links), InputError);
}

TEST(Geodesics, PointsInLineFarOutliersAndSinglePointsHaveDistances) {
  Points points;
  for (int i = 0; i < 40; ++i) points.emplace_back(0.1 * i, 0.0, 0.0);
  points.emplace_back(1e5, 0.0, 0.0);
  for (const OrAuto<double>& geodesic_exponent : {OrAuto<double>(), OrAuto<double>(64.0)}) {
    const Lists links = nearestNeighbors(points, 8);
    const GeodesicGraph graph = buildGeodesicGraph(points, {}, links, geodesic_exponent);
    const std::vector<double> distance = findGeodesicDistances(graph, points, links);
    for (Index e = links.offsets[5]; e < links.offsets[6]; ++e) {
      EXPECT_NEAR(distance[e], 0.1 * std::abs(links.items[e] - 5), 1e-12);
    }
    for (double weight : geodesicWeights(graph, points, links)) EXPECT_TRUE(weight >= 0.0 && weight <= 1.0);
    EXPECT_EQ(keepGeodesicNeighbors(graph, points, {}, links).lists.size(), 41);
  }
  const Points single(1, Vec3::Zero());
  const Lists none = nearestNeighbors(single, 8);
  EXPECT_EQ(keepGeodesicNeighbors(buildGeodesicGraph(single, {}, none, {}), single, {}, none).lists.count(0), 0);
}

// Bars whose gap is narrower than the spacing of the remaining points.
struct Thinned {
  Gapped bars = makeTwoBars(2.0, 0.1);
  Lists neighbors;
  std::vector<Index> kept;

  Thinned() {
    const Lists listed = nearestNeighbors(bars.positions, kListed);
    const SurfaceSides sides{bars.normals, false};
    neighbors = keepGeodesicNeighbors(buildGeodesicGraph(bars.positions, sides, listed, {}), bars.positions, sides, listed).lists;
    const std::vector<char> is_corner = findBoundary(bars.positions, bars.normals, neighbors, kListed / 2).is_corner;
    kept = simplify(bars.positions, bars.normals, kListed / 2, 60, {}, neighbors, is_corner, true).keepCount(60);
  }
};

TEST(GeodesicCells, CoarsePointsOnBothSidesOfANarrowGapAreNoNeighbours) {
  const Thinned thinned;
  const GeodesicCells cells = findGeodesicCells(thinned.bars.positions, thinned.neighbors, thinned.kept, 16);
  Index across = 0, within = 0;
  for (Index a = 0; a < cells.neighbors.size(); ++a) {
    for (const Index* b = cells.neighbors.begin(a); b != cells.neighbors.end(a); ++b) {
      const Index i = thinned.kept[a], j = thinned.kept[*b];
      if (!thinned.bars.is_asked[i] || !thinned.bars.is_asked[j]) continue;
      ++(thinned.bars.part[i] == thinned.bars.part[j] ? within : across);
    }
  }
  EXPECT_EQ(across, 0);
  EXPECT_GT(within, 100);
}

TEST(GeodesicCells, PointsFollowTheirOwnSideOfANarrowGap) {
  const Thinned thinned;
  const GeodesicCells cells = findGeodesicCells(thinned.bars.positions, thinned.neighbors, thinned.kept, 16);
  const Lists followed = findChosenNear(cells, thinned.bars.positions, 8);
  Index across = 0;
  for (Index i = 0; i < followed.size(); ++i) {
    EXPECT_GE(followed.count(i), 3);
    for (const Index* a = followed.begin(i); a != followed.end(i); ++a) {
      const Index j = thinned.kept[*a];
      across += thinned.bars.is_asked[i] && thinned.bars.is_asked[j] && thinned.bars.part[i] != thinned.bars.part[j];
    }
  }
  EXPECT_EQ(across, 0);
}

TEST(GeodesicCells, PointsInsertedBetweenOthersFollowTheSideOfTheirCell) {
  const Thinned thinned;
  const Points& positions = thinned.bars.positions;
  const GeodesicCells cells = findGeodesicCells(positions, thinned.neighbors, thinned.kept, 16);
  Points middles;
  for (Index i = 0; i < thinned.neighbors.size(); ++i)
    middles.push_back(0.5 * (positions[i] + positions[thinned.neighbors.begin(i)[0]]));
  const Lists followed = findChosenNear(cells, cells.owner, middles, 8);
  const KdTree tree(cells.chosen);
  std::vector<Neighbor> nearest;
  Index across = 0, across_in_space = 0;
  for (Index i = 0; i < followed.size(); ++i) {
    const auto isAcross = [&](Index a) {
      const Index j = thinned.kept[a];
      return thinned.bars.is_asked[i] && thinned.bars.is_asked[j] && thinned.bars.part[i] != thinned.bars.part[j];
    };
    for (const Index* a = followed.begin(i); a != followed.end(i); ++a) across += isAcross(*a);
    tree.nearest(middles[i], 8, nearest);
    for (const Neighbor& other : nearest) across_in_space += isAcross(other.index);
  }
  EXPECT_EQ(across, 0);
  EXPECT_GT(across_in_space, 100);
}

TEST(GeodesicCells, RefusedPairsAreThoseAcrossTheGap) {
  const Thinned thinned;
  const GeodesicCells cells = findGeodesicCells(thinned.bars.positions, thinned.neighbors, thinned.kept, 16);
  const Lists refused = findRefusedPairs(cells.chosen, cells.neighbors);
  Index across = 0, within = 0;
  for (Index a = 0; a < refused.size(); ++a) {
    for (const Index* b = refused.begin(a); b != refused.end(a); ++b) {
      const Index i = thinned.kept[a], j = thinned.kept[*b];
      EXPECT_TRUE(std::binary_search(refused.begin(*b), refused.end(*b), a)) << "not symmetric";
      if (thinned.bars.is_asked[i] && thinned.bars.is_asked[j])
        ++(thinned.bars.part[i] == thinned.bars.part[j] ? within : across);
    }
  }
  EXPECT_GT(across, 100);
  EXPECT_EQ(within, 0);
}

TEST(GeodesicCells, WithoutGapsTheNearestInSpaceAreFound) {
  const TestSurface sphere = makeSphere(3000);
  const Lists neighbors = nearestNeighbors(sphere.positions, kListed);
  const std::vector<Index> kept = simplify(sphere.positions, sphere.normals, 16, 300, {}).keepCount(300);
  const GeodesicCells cells = findGeodesicCells(sphere.positions, neighbors, kept, 16);
  EXPECT_EQ(cells.neighbors.items, nearestNeighbors(cells.chosen, 16).items);
  const Lists followed = findChosenNear(cells, sphere.positions, 8);
  const KdTree tree(cells.chosen);
  std::vector<Neighbor> nearest;
  for (Index i = 0; i < sphere.size(); ++i) {
    tree.nearest(sphere.positions[i], 8, nearest);
    for (Index m = 0; m < 8; ++m) ASSERT_EQ(followed.begin(i)[m], nearest[m].index);
  }
}

TEST(GeodesicSimplification, WithoutGapsItIsThatOfSpace) {
  const TestSurface sheet = makeSheet(50, 0.2);
  const Lists neighbors = nearestNeighbors(sheet.positions, kListed);
  const std::vector<char> is_corner = findBoundary(sheet.positions, sheet.normals, neighbors, 16).is_corner;
  EXPECT_EQ(simplify(sheet.positions, sheet.normals, 16, 50, {}, neighbors, is_corner, true).removed,
            simplify(sheet.positions, sheet.normals, 16, 50, {}, neighbors, is_corner, false).removed);
}

TEST(GeodesicSimplification, LeavesNoPointsTogetherOnARoughSheet) {
  const Gapped sheet = makeRoughSheet(0.5, 0.2);
  const Lists links = nearestNeighbors(sheet.positions, kListed);
  const SurfaceSides sides = estimateSides(sheet.positions);
  const GeodesicGraph graph = buildGeodesicGraph(sheet.positions, sides, links, {});
  const auto measureNearest = [&](const Lists& neighbors, bool over_surface) {
    const std::vector<char> is_corner = findBoundary(sheet.positions, sides.normals, neighbors, kListed / 2).is_corner;
    const std::vector<Index> kept =
        simplify(sheet.positions, sides.normals, kListed / 2, 150, {}, neighbors, is_corner, over_surface).keepCount(150);
    double nearest = kNoLimit;
    for (Index i : kept)
      for (Index j : kept)
        if (i != j && !(is_corner[i] && is_corner[j]))
          nearest = std::min(nearest, (sheet.positions[i] - sheet.positions[j]).norm());
    return nearest;
  };
  // Nine tenths, because other links give another set of points.
  const Lists kept = keepGeodesicNeighbors(graph, sheet.positions, sides, links).lists;
  EXPECT_GE(measureNearest(kept, true), 0.9 * measureNearest(links, false));
}

// The mesh of a real garment. Its edges, and the edges across them, give the true distances.
struct Garment {
  Points positions, normals;
  GeodesicGraph truth;
};

std::optional<Garment> readGarment(const std::string& name) {
  std::ifstream file(test::sharedFolder() + "/" + name);
  if (!file) return std::nullopt;
  Garment garment;
  std::vector<std::array<Index, 3>> faces;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "v") {
      Vec3 p;
      words >> p[0] >> p[1] >> p[2];
      garment.positions.push_back(p);
    } else if (key == "f") {
      std::array<Index, 3> face{};
      for (Index& corner : face) {
        words >> key;
        corner = std::stoi(key) - 1;
      }
      faces.push_back(face);
    }
  }
  garment.normals.assign(garment.positions.size(), Vec3::Zero());
  std::vector<std::set<Index>> linked(garment.positions.size());
  std::map<std::pair<Index, Index>, Index> opposite;
  for (const auto& face : faces) {
    const Vec3 &a = garment.positions[face[0]], &b = garment.positions[face[1]], &c = garment.positions[face[2]];
    for (int s = 0; s < 3; ++s) {
      const Index i = face[s], j = face[(s + 1) % 3], k = face[(s + 2) % 3];
      garment.normals[i] += (b - a).cross(c - a);
      linked[i].insert(j);
      linked[j].insert(i);
      const auto [other, is_new] = opposite.emplace(std::minmax(i, j), k);
      if (is_new) continue;
      linked[k].insert(other->second);
      linked[other->second].insert(k);
    }
  }
  for (Vec3& normal : garment.normals) normal.normalize();
  for (std::size_t i = 0; i < linked.size(); ++i) {
    for (Index j : linked[i]) {
      garment.truth.links.items.push_back(j);
      garment.truth.cost.push_back((garment.positions[j] - garment.positions[i]).norm());
    }
    garment.truth.links.offsets.push_back(static_cast<Index>(garment.truth.links.items.size()));
  }
  return garment;
}

// Detour over the edges of a triangle mesh up to which two vertices are near on its surface.
constexpr double kNearDetour = 1.35;

// Shares of the sixteen nearest points that keep half of their weight: of points near on the mesh, and of points so far on it
// that they should have no weight.
Coupling measureKept(const Garment& garment, bool with_normals) {
  const Lists links = nearestNeighbors(garment.positions, 16), listed = nearestNeighbors(garment.positions, kListed);
  const std::vector<double> truth = findGeodesicDistances(garment.truth, garment.positions, links, 2.0 * kLongestDetour);
  const SurfaceSides sides = with_normals ? SurfaceSides{garment.normals, true} : estimateSides(garment.positions);
  const std::vector<double> weight =
      geodesicWeights(buildGeodesicGraph(garment.positions, sides, listed, {}), garment.positions, links);
  Coupling kept, all;
  for (Index i = 0; i < links.size(); ++i) {
    for (Index e = links.offsets[i]; e < links.offsets[i + 1]; ++e) {
      const double detour = truth[e] / (garment.positions[links.items[e]] - garment.positions[i]).norm();
      if (detour < kNearDetour) {
        all.within += 1.0;
        kept.within += weight[e] >= 0.5;
      } else if (detour > kLongestDetour) {
        all.across += 1.0;
        kept.across += weight[e] >= 0.5;
      }
    }
  }
  return {kept.within / all.within, kept.across / all.across};
}

TEST(GeodesicsOfGarments, LegsOfTrousersAreToldApart) {
  const std::optional<Garment> trousers = readGarment("trousers_cc0/trousers_cc0_legs_close.obj");
  if (!trousers) GTEST_SKIP() << "DEFORMABLE_SURFACE_DATA names no folder that holds the trousers";
  const Coupling given = measureKept(*trousers, true);
  EXPECT_GE(given.within, kLeastWithin);
  EXPECT_LE(given.across, kMostAcross);
  // The gap is half to three local spacings wide. Normals estimated across it are less reliable.
  const Coupling estimated = measureKept(*trousers, false);
  EXPECT_GE(estimated.within, kLeastWithin);
  EXPECT_LE(estimated.across, 0.2);
}

TEST(GeodesicsOfGarments, FrontAndBackOfAShirtThatLiesFlatAreToldApart) {
  const std::optional<Garment> shirt = readGarment("diffcloth_garments/tshirt1900-flattened.obj");
  if (!shirt) GTEST_SKIP() << "DEFORMABLE_SURFACE_DATA names no folder that holds the shirt";
  const Coupling given = measureKept(*shirt, true);
  EXPECT_LE(given.across, kMostAcross);
  EXPECT_GE(given.within, 0.88) << "seams and wrinkles turn by more than the sampling shows";
  const Coupling estimated = measureKept(*shirt, false);
  EXPECT_LE(estimated.across, kMostAcross);
  EXPECT_GE(estimated.within, 0.8);
}

}  // namespace
}  // namespace deformable_surface::cloud
