// Connectivity of surfaces with known answers: rings of grids, areas, boundaries, corners, topology, inputs without a surface.
#include "deformable_surface/cloud/rings.h"

#include "cloud/test_surfaces.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace deformable_surface::cloud {
namespace {

constexpr Index kNeighbors = 16;

Rings build(const TestSurface& surface) {
  return buildRings(surface.positions, surface.normals, nearestNeighbors(surface.positions, kNeighbors));
}

Boundary findBoundaryOf(const TestSurface& surface) {
  return findBoundary(surface.positions, surface.normals, nearestNeighbors(surface.positions, 2 * kNeighbors), kNeighbors);
}

bool hasLink(const Rings& rings, Index i, Index j) { return std::count(rings.ring.begin(i), rings.ring.end(i), j) == 1; }

double sumAreas(const Rings& rings) { return std::accumulate(rings.area.begin(), rings.area.end(), 0.0); }

double sumTriangles(const TestSurface& surface, const Rings& rings) {
  double sum = 0.0;
  for (const Triangle& t : rings.triangles) {
    const Vec3 &a = surface.positions[t.corner[0]], &b = surface.positions[t.corner[1]], &c = surface.positions[t.corner[2]];
    sum += t.weight * 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

void expectSound(const TestSurface& surface, const Rings& rings) {
  const Index n = surface.size();
  ASSERT_EQ(rings.ring.size(), n);
  ASSERT_EQ(static_cast<Index>(rings.open.size()), n);
  ASSERT_EQ(static_cast<Index>(rings.area.size()), n);
  Index isolated = 0;
  for (Index i = 0; i < n; ++i) {
    EXPECT_GE(rings.area[i], 0.0);
    isolated += rings.ring.count(i) == 0;
    for (const Index* j = rings.ring.begin(i); j != rings.ring.end(i); ++j) {
      EXPECT_NE(*j, i);
      EXPECT_TRUE(hasLink(rings, *j, i)) << i << " - " << *j;
    }
  }
  EXPECT_EQ(rings.num_isolated, isolated);
  for (std::size_t t = 0; t < rings.triangles.size(); ++t) {
    const auto& [a, b, c] = rings.triangles[t].corner;
    EXPECT_LT(a, std::min(b, c));
    EXPECT_GT(rings.triangles[t].weight, 0.0);
    EXPECT_GE(hasLink(rings, a, b) + hasLink(rings, b, c) + hasLink(rings, c, a), 2);  // the star that holds it has two
    if (t == 0) continue;
    const auto& [a0, b0, c0] = rings.triangles[t - 1].corner;
    EXPECT_LT(std::tie(a0, b0, c0), std::tie(a, b, c));
  }
}

// A fan of near neighbours in one direction, two far ones, and one between them that is the farthest of all, but within the
// circle through them.
TEST(Rings, HaveTheirMembersAmongFartherNeighboursToo) {
  TestSurface surface;
  const auto add = [&](double degrees, double distance) {
    const double angle = degrees / 180.0 * 3.14159265358979323846;
    surface.positions.emplace_back(distance * std::cos(angle), distance * std::sin(angle), 0.0);
    surface.normals.push_back(Vec3::UnitZ());
  };
  add(0.0, 0.0);
  for (int k = 0; k < 14; ++k) add(-7.0 + k, 1.0 + 0.04 * ((5 * k) % 14));
  add(120.0, 3.0);
  add(240.0, 3.0);
  add(180.0, 3.2);
  const Index farthest = surface.size() - 1;
  const Lists neighbors = nearestNeighbors(surface.positions, farthest);
  ASSERT_EQ(neighbors.end(0)[-1], farthest);
  const Rings rings = buildRings(surface.positions, surface.normals, neighbors);
  EXPECT_TRUE(hasLink(rings, 0, farthest));
  const auto passesOver = [&](const Triangle& t) {
    const auto [low, high] = std::minmax(t.corner[1], t.corner[2]);
    return t.corner[0] == 0 && low == farthest - 2 && high == farthest - 1;
  };
  EXPECT_TRUE(std::none_of(rings.triangles.begin(), rings.triangles.end(), passesOver));
}

TEST(Rings, GridHasBothDiagonalsEverywhereHoweverItIsTurned) {
  const Index side = 12;
  for (int turn = 0; turn < 8; ++turn) {
    TestSurface sheet = makeSheet(side);
    sheet.rotate(makeRotation(0.7 * turn, 0.31 * turn));
    for (Vec3& p : sheet.positions) p = p.cast<float>().cast<double>();
    const Rings rings = build(sheet);
    expectSound(sheet, rings);
    for (Index x = 0; x + 1 < side; ++x) {
      for (Index y = 0; y + 1 < side; ++y) {
        const Index corner = x * side + y;
        ASSERT_TRUE(hasLink(rings, corner, corner + side + 1)) << "turn " << turn << ", square " << x << " " << y;
        ASSERT_TRUE(hasLink(rings, corner + 1, corner + side)) << "turn " << turn << ", square " << x << " " << y;
      }
    }
    for (Index i = 0; i < sheet.size(); ++i) {
      const Index x = i / side, y = i % side;
      const bool at_x = x == 0 || x == side - 1, at_y = y == 0 || y == side - 1;
      ASSERT_EQ(rings.ring.count(i), at_x && at_y ? 3 : at_x || at_y ? 5 : 8);
      ASSERT_EQ(rings.open[i] != 0, at_x || at_y);
      const double cell = 1.0 / (side - 1) / (side - 1);
      ASSERT_NEAR(rings.area[i], cell * (at_x ? 0.5 : 1.0) * (at_y ? 0.5 : 1.0), 1e-7);
    }
    ASSERT_EQ(rings.triangles.size(), 4u * (side - 1) * (side - 1));
    for (const Triangle& t : rings.triangles) ASSERT_NEAR(t.weight, 0.5, 1e-12);
  }
}

TEST(Rings, RingsTurnCounterClockwiseAboutTheNormal) {
  const TestSurface sphere = makeSphere(600);
  const Rings rings = build(sphere);
  expectSound(sphere, rings);
  for (Index i = 0; i < sphere.size(); ++i) {
    EXPECT_FALSE(rings.open[i]);
    const Vec3 &p = sphere.positions[i], &n = sphere.normals[i];
    double turned = 0.0;
    for (Index r = 0; r < rings.ring.count(i); ++r) {
      const Vec3 a = sphere.positions[rings.ring.begin(i)[r]] - p;
      const Vec3 b = sphere.positions[rings.ring.begin(i)[(r + 1) % rings.ring.count(i)]] - p;
      EXPECT_GT(a.cross(b).dot(n), 0.0);
      const Vec3 in_plane_a = a - a.dot(n) * n, in_plane_b = b - b.dot(n) * n;
      turned += std::atan2(in_plane_a.cross(in_plane_b).dot(n), in_plane_a.dot(in_plane_b));
    }
    EXPECT_NEAR(turned, 2.0 * kPi, 1e-9);
  }
  for (const Triangle& t : rings.triangles) {
    const Vec3 &a = sphere.positions[t.corner[0]], &b = sphere.positions[t.corner[1]], &c = sphere.positions[t.corner[2]];
    EXPECT_GT((b - a).cross(c - a).dot(a + b + c), 0.0);
  }
}

TEST(Rings, AreasOfASheetSumToItsArea) {
  const TestSurface grid = makeSheet(20);
  EXPECT_NEAR(sumAreas(build(grid)), 1.0, 1e-12);
  EXPECT_NEAR(sumTriangles(grid, build(grid)), 1.0, 1e-12);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const TestSurface sheet = makeSheet(20, 0.2, seed);
    const Rings rings = build(sheet);
    expectSound(sheet, rings);
    // Exact but for cells of five and more corners within the tolerance of a tie, on which the corners need not agree.
    EXPECT_NEAR(sumAreas(rings), 1.0, 2e-4);
    EXPECT_NEAR(sumTriangles(sheet, rings), sumAreas(rings), 1e-12);
  }
}

double measure(const TestSurface& surface) {
  return measureArea(surface.positions, surface.normals, nearestNeighbors(surface.positions, kNeighbors));
}

TEST(Rings, TheAreaAloneIsTheSumOfTheirs) {
  for (const TestSurface& surface : {makeSheet(20, 0.3), makeSheet(15), makeSphere(500), makeTorus(40, 20, 0.2)}) {
    const double sum = sumAreas(build(surface));
    EXPECT_NEAR(measure(surface), sum, 1e-13 * sum);  // the same terms in another order
  }
}

// What is known of the lists saves time alone. One point in three lacks a neighbour, as beside a gap.
TEST(Rings, TheAreaIsTheSameWhereListsAreKnownToBeTheNearest) {
  for (const TestSurface& surface : {makeSheet(20, 0.3), makeSheet(15), makeSphere(500), makeTorus(40, 20, 0.2)}) {
    const Lists nearest = nearestNeighbors(surface.positions, kNeighbors);
    const std::vector<char> are_nearest(nearest.size(), 1);
    EXPECT_EQ(measureArea(surface.positions, surface.normals, nearest),
              measureArea(surface.positions, surface.normals, nearest, are_nearest));
    Lists lacking;
    std::vector<char> are_whole;
    for (Index i = 0; i < nearest.size(); ++i) {
      are_whole.push_back(i % 3 != 0);
      for (Index k = 0; k < nearest.count(i); ++k)
        if (are_whole[i] || k != 2) lacking.items.push_back(nearest.begin(i)[k]);
      lacking.offsets.push_back(static_cast<Index>(lacking.items.size()));
    }
    EXPECT_EQ(measureArea(surface.positions, surface.normals, lacking),
              measureArea(surface.positions, surface.normals, lacking, are_whole));
  }
}

TEST(Rings, TheAreaReachesTheSidesBetweenPointsThatLieALittleInside) {
  constexpr double kInside = 0.15 / 19.0;
  TestSurface sheet = makeSheet(20);
  Index count = 0;
  for (Vec3& p : sheet.positions)
    if (p.y() < 1e-9 && p.x() > 0.03 && p.x() < 0.97 && ++count % 2 == 0) p.y() += kInside;
  EXPECT_NEAR(measure(sheet), 1.0, 1e-4);
}

// A lattice with a round hole, whose rim has points on the circle. The triangles across it have 1.5 to 2.1 % of the area.
TEST(Rings, TheAreaLeavesOutHoles) {
  constexpr Index kSide = 40;
  constexpr double kSpacing = 1.0 / (kSide - 1);
  for (const double jitter : {0.0, 0.3})
    for (const double spacings : {5.0, 8.0, 12.0}) {
      const double radius = spacings * kSpacing;
      TestSurface sheet;
      for (Vec3 p : makeSheet(kSide, jitter).positions) {
        const Vec3 out = p - Vec3(0.5, 0.5, 0.0);
        if (out.norm() < radius - 0.5 * kSpacing) continue;
        if (out.norm() < radius + 0.5 * kSpacing) p = Vec3(0.5, 0.5, 0.0) + radius * out.normalized();
        sheet.add(p, Vec3::UnitZ());
      }
      EXPECT_NEAR(measure(sheet), 1.0 - kPi * radius * radius, 8e-3) << jitter << ", " << spacings;
    }
}

TEST(Rings, TheAreaIsRightWhereListsLackNearPoints) {
  const TestSurface sheet = makeSheet(30, 0.3);
  Lists neighbors = nearestNeighbors(sheet.positions, kNeighbors), lacking;
  for (Index i = 0; i < neighbors.size(); ++i) {
    for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j)
      if ((i + *j) % 37 != 0) lacking.items.push_back(*j);  // neither of the two lists the other
    lacking.offsets.push_back(static_cast<Index>(lacking.items.size()));
  }
  EXPECT_NEAR(measureArea(sheet.positions, sheet.normals, lacking), 1.0, 1e-3);
}

TEST(Rings, AreasOfASphereConvergeWithTheSquareOfTheSpacing) {
  // Tangent planes see projected areas, and near ties fall differently along the spiral: the error times n is bounded.
  for (int n : {500, 2000, 8000}) {
    const double error = 1.0 - sumAreas(build(makeSphere(n))) / (4.0 * kPi);
    EXPECT_LT(std::abs(error) * n, 8.0) << n;
  }
}

TEST(Rings, PointsTooFarToBeLinkedStaySeparate) {
  TestSurface surface = makeSheet(10, 0.2);
  const Index n = surface.size();
  surface.add(Vec3(3.0, 0.5, 0.0), Vec3::UnitZ());
  surface.append(makeSheet(3), Vec3(-4.0, 0.0, 0.0));
  const Rings rings = build(surface);
  expectSound(surface, rings);
  EXPECT_EQ(rings.num_isolated, 1);
  EXPECT_EQ(rings.ring.count(n), 0);
  EXPECT_TRUE(rings.open[n]);
  Index num_components = 0;
  const std::vector<Index> label = labelComponents(rings, num_components);
  EXPECT_EQ(num_components, 2);
  EXPECT_EQ(label[0], 0);
  EXPECT_EQ(label[n], -1);
  EXPECT_EQ(label[n + 1], 1);
  EXPECT_NEAR(sumAreas(rings), 2.0, 1e-3);
}

TEST(Rings, NeighborAlongTheNormalDoesNotSpoilTheRing) {
  TestSurface surface = makeSheet(11);
  const Index center = 5 * 11 + 5;
  surface.add(surface.positions[center] + Vec3(1e-9, 0.0, 0.05), Vec3::UnitZ());
  const Rings rings = build(surface);
  expectSound(surface, rings);
  EXPECT_EQ(rings.ring.count(center), 8);
  EXPECT_NEAR(sumAreas(rings), 1.0, 0.03);
}

// Beside a gap a point has neighbours on one side only, although it is on no boundary. Three points that are in line within the
// digits of the file are no triangle there.
TEST(Rings, PointsInLineBesideAGapSpanNoSliver) {
  constexpr Index kSide = 11, kRow = 5;
  TestSurface surface = makeSheet(kSide);
  const Index end = kRow * kSide + 3, beyond = end + 2;
  const double below = surface.positions[end].x(), spacing = (surface.positions[1] - surface.positions[0]).norm();
  surface.positions[beyond].x() -= 1e-4 * spacing;
  const Lists listed = nearestNeighbors(surface.positions, 2 * kNeighbors);
  Lists cut;
  for (Index i = 0; i < listed.size(); ++i) {
    for (const Index* j = listed.begin(i); j != listed.end(i); ++j)
      if (i != end || surface.positions[*j].x() > below - 0.5 * spacing) cut.items.push_back(*j);
    cut.offsets.push_back(static_cast<Index>(cut.items.size()));
  }
  const Rings rings = buildRings(surface.positions, surface.normals, cut);
  expectSound(surface, rings);
  for (const Triangle& t : rings.triangles) {
    const Vec3 &a = surface.positions[t.corner[0]], &b = surface.positions[t.corner[1]], &c = surface.positions[t.corner[2]];
    EXPECT_GT((b - a).cross(c - a).norm(), 0.1 * spacing * spacing) << t.corner[0] << ' ' << t.corner[1] << ' ' << t.corner[2];
  }
}

// As on a sharp crease whose normals are the mean of both faces': there only the row is near over the surface. As in a file, the
// coordinates are rounded, so that the points lie beside the line.
TEST(Rings, PointsInLineWhoseNormalsTurnSpanNoSliver) {
  const Vec3 along = Vec3(0.7, 0.4, -0.6).normalized();
  TestSurface row;
  for (Index k = 0; k < 60; ++k) {
    row.positions.push_back(((Vec3(-6.0, -12.0, -8.0) + 0.78 * k * along) * 1e8).array().round() * 1e-8);
    const Vec3 turning(std::sin(0.9 * k), std::cos(1.7 * k), 0.5);
    row.normals.push_back((turning - 0.9 * turning.dot(along) * along).normalized());
  }
  EXPECT_TRUE(build(row).triangles.empty());
}

TEST(Rings, CloudsWithoutASurfaceGiveNoTrianglesOrAreSound) {
  TestSurface line, pair, one, none, copies_apart;
  for (int i = 0; i < 50; ++i) line.add(Vec3(0.1 * i, 0.0, 0.0), Vec3::UnitZ());
  pair.add(Vec3::Zero(), Vec3::UnitZ());
  one = pair;
  pair.add(Vec3::UnitX(), Vec3::UnitZ());
  for (const TestSurface* surface : {&line, &pair, &one, &none}) {
    const Rings rings = build(*surface);
    expectSound(*surface, rings);
    EXPECT_TRUE(rings.triangles.empty());
    EXPECT_EQ(sumAreas(rings), 0.0);
  }
  EXPECT_EQ(build(line).ring.count(25), 2);
  EXPECT_EQ(build(one).num_isolated, 1);

  TestSurface volume;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    volume.add(Vec3(normal(random), normal(random), normal(random)), Vec3(normal(random), normal(random), normal(random)));
  }
  expectSound(volume, build(volume));
  measureTopology(build(volume));
}

TEST(Rings, DoNotDependOnTheNumberOfThreads) {
  const TestSurface sheet = makeSheet(60, 0.3);
  setNumThreads(1);
  const Rings one = build(sheet);
  setNumThreads(3);
  const Rings three = build(sheet);
  setNumThreads(0);
  EXPECT_EQ(one.ring.items, three.ring.items);
  EXPECT_EQ(one.ring.offsets, three.ring.offsets);
  EXPECT_EQ(one.area, three.area);
  ASSERT_EQ(one.triangles.size(), three.triangles.size());
  for (std::size_t t = 0; t < one.triangles.size(); ++t) {
    EXPECT_TRUE(std::equal(one.triangles[t].corner, one.triangles[t].corner + 3, three.triangles[t].corner));
    EXPECT_EQ(one.triangles[t].weight, three.triangles[t].weight);
  }
}

TEST(Rings, ListsOfDifferentLengthAreRefused) {
  TestSurface sheet = makeSheet(4);
  const Lists neighbors = nearestNeighbors(sheet.positions, kNeighbors);
  sheet.normals.pop_back();
  EXPECT_THROW(buildRings(sheet.positions, sheet.normals, neighbors), InputError);
  EXPECT_THROW(findBoundary(sheet.positions, sheet.normals, neighbors, 8), InputError);
  sheet.normals.push_back(Vec3::UnitZ());
  EXPECT_THROW(findBoundary(sheet.positions, sheet.normals, neighbors, 0), InputError);
}

TEST(Boundary, OfWhichOnlySoManyCornersAreWantedKeepsTheSharpest) {
  // Right angles, and one corner cut back so that it is sharper.
  TestSurface sheet = makeSheet(24);
  TestSurface cut;
  const double side = sheet.positions.back().x();
  for (Index i = 0; i < sheet.size(); ++i) {
    const Vec3& p = sheet.positions[i];
    if (p.y() <= 0.5 * side + 0.5 * p.x()) cut.add(p, sheet.normals[i]);
  }
  Boundary boundary = findBoundaryOf(cut);
  ASSERT_GT(std::count(boundary.is_corner.begin(), boundary.is_corner.end(), 1), 2);
  const std::vector<float> gaps = boundary.corner_gap;
  limitCorners(2, boundary);
  EXPECT_EQ(std::count(boundary.is_corner.begin(), boundary.is_corner.end(), 1), 2);
  for (std::size_t kept = 0; kept < gaps.size(); ++kept)
    for (std::size_t gone = 0; gone < gaps.size(); ++gone)
      if (boundary.is_corner[kept] && gaps[gone] > 0.0f && !boundary.is_corner[gone]) EXPECT_GE(gaps[kept], gaps[gone]);
  limitCorners(0, boundary);
  EXPECT_EQ(std::count(boundary.is_corner.begin(), boundary.is_corner.end(), 1), 0);
}

TEST(Boundary, OfAJitteredSheetIsItsOutlineWithFourCorners) {
  const Index side = 24;
  for (double jitter : {0.0, 0.1, 0.3}) {
    TestSurface sheet = makeSheet(side, jitter);
    sheet.rotate(makeRotation(0.4, 0.9));
    const Boundary boundary = findBoundaryOf(sheet);
    for (Index i = 0; i < sheet.size(); ++i) {
      const Index x = i / side, y = i % side;
      const bool at_x = x == 0 || x == side - 1, at_y = y == 0 || y == side - 1;
      EXPECT_EQ(boundary.is_boundary[i] != 0, at_x || at_y) << "jitter " << jitter << ", point " << x << " " << y;
      EXPECT_EQ(boundary.is_corner[i] != 0, at_x && at_y) << "jitter " << jitter << ", point " << x << " " << y;
    }
  }
}

TEST(Boundary, OfADiscIsItsCircleWithoutCorners) {
  const int rings = 12;
  const TestSurface disc = makeDisc(rings);
  const Boundary boundary = findBoundaryOf(disc);
  for (Index i = 0; i < disc.size(); ++i) {
    EXPECT_EQ(boundary.is_boundary[i] != 0, i >= disc.size() - 6 * rings) << i;
    EXPECT_FALSE(boundary.is_corner[i]) << i;
  }
}

TEST(Boundary, IsAbsentOnClosedSurfaces) {
  for (const TestSurface& surface : {makeSphere(1000), makeTorus(60, 24, 0.2)}) {
    const Boundary boundary = findBoundaryOf(surface);
    EXPECT_EQ(std::count(boundary.is_boundary.begin(), boundary.is_boundary.end(), 1), 0);
  }
}

TEST(Boundary, EndsOfAStringAreItsCorners) {
  TestSurface line;
  for (int i = 0; i < 100; ++i) line.add(Vec3(0.01 * i, 0.0, 0.0), Vec3::UnitY());
  const Boundary boundary = findBoundaryOf(line);
  for (Index i = 0; i < line.size(); ++i) EXPECT_EQ(boundary.is_corner[i] != 0, i == 0 || i == 99) << i;
}

void expectTopology(const TestSurface& surface, Index components, Index loops, Index euler_characteristic) {
  const Topology topology = measureTopology(build(surface));
  EXPECT_EQ(topology.components, components);
  EXPECT_EQ(topology.boundary_loops, loops);
  EXPECT_EQ(topology.euler_characteristic, euler_characteristic);
}

TEST(Topology, SheetHasOneLoop) {
  expectTopology(makeSheet(15), 1, 1, 1);
  for (unsigned seed = 1; seed <= 10; ++seed) {
    TestSurface sheet = makeSheet(15, 0.25, seed);
    sheet.rotate(makeRotation(0.3 * seed, 0.5 * seed));
    expectTopology(sheet, 1, 1, 1);
  }
}

TEST(Topology, SpheresAreClosed) {
  for (int n : {100, 400, 1500}) expectTopology(makeSphere(n), 1, 0, 2);
  TestSurface two = makeSphere(400);
  two.append(makeSphere(300), Vec3(5.0, 0.0, 0.0));
  expectTopology(two, 2, 0, 4);
}

TEST(Topology, TorusHasAHandle) {
  expectTopology(makeTorus(60, 24, 0.0), 1, 0, 0);
  expectTopology(makeTorus(60, 24, 0.2), 1, 0, 0);
}

TEST(Topology, SheetWithAHoleHasTwoLoops) {
  TestSurface all = makeSheet(24, 0.2), rest;
  for (Index i = 0; i < all.size(); ++i) {
    if ((all.positions[i] - Vec3(0.5, 0.5, 0.0)).norm() > 0.2) rest.add(all.positions[i], all.normals[i]);
  }
  expectTopology(rest, 1, 2, 0);
}

}  // namespace
}  // namespace deformable_surface::cloud
