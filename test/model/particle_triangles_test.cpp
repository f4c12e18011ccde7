// Triangulations of particle sets whose topology is known, the rule at ties and obtuse triangles, chains, and refusals.
#include "deformable_surface/model/oriented_particles/particle_triangles.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "model/particle_surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace deformable_surface::model {
namespace {

constexpr double kMaxEdge = 2.0;  // spacings

std::vector<WeightedTriangle> triangulate(const TestSurface& surface, double max_edge) {
  return triangulateParticles(surface.positions, surface.normals, max_edge);
}

// No edge in the same direction twice, corners turn about their normals, sorted.
void expectManifold(const TestSurface& surface, const std::vector<WeightedTriangle>& triangles) {
  std::map<std::pair<Index, Index>, int> uses;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& corner = triangles[t].corner;
    EXPECT_LT(corner[0], std::min(corner[1], corner[2]));
    EXPECT_EQ(triangles[t].weight, 1.0);
    const Vec3 &a = surface.positions[corner[0]], &b = surface.positions[corner[1]], &c = surface.positions[corner[2]];
    for (int s = 0; s < 3; ++s) {
      EXPECT_GT((b - a).cross(c - a).dot(surface.normals[corner[s]]), 0.0);
      EXPECT_EQ(++uses[std::make_pair(corner[s], corner[(s + 1) % 3])], 1);
    }
    if (t == 0) continue;
    EXPECT_TRUE(std::lexicographical_compare(triangles[t - 1].corner, triangles[t - 1].corner + 3, corner, corner + 3));
  }
}

double sumAreas(const TestSurface& surface, const std::vector<WeightedTriangle>& triangles) {
  double sum = 0.0;
  for (const WeightedTriangle& t : triangles) {
    const Vec3 &a = surface.positions[t.corner[0]], &b = surface.positions[t.corner[1]], &c = surface.positions[t.corner[2]];
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

void expectTopology(const TestSurface& surface, double max_edge, Index components, Index loops, Index euler_characteristic) {
  const std::vector<WeightedTriangle> triangles = triangulate(surface, max_edge);
  expectManifold(surface, triangles);
  const ParticleTopology topology = measureTopology(surface.size(), triangles);
  EXPECT_EQ(topology.components, components);
  EXPECT_EQ(topology.boundary_loops, loops);
  EXPECT_EQ(topology.euler_characteristic, euler_characteristic);
  EXPECT_EQ(topology.isolated, 0);
  EXPECT_EQ(topology.closed, loops == 0);
  EXPECT_EQ(topology.genus, loops == 0 ? components - euler_characteristic / 2 : 0);
}

TEST(ParticleTriangles, HolesOfFiveAndMoreParticlesStayOpenAndNoTriangleSpansACut) {
  // A missing particle of a lattice is a hole.
  TestSurface sheet = makeHexagons(0.1, 0.81), vacancy;
  for (Index i = 0; i < sheet.size(); ++i)
    if (sheet.positions[i].norm() > 0.05) vacancy.add(sheet.positions[i], sheet.normals[i]);
  EXPECT_EQ(measureTopology(vacancy.size(), triangulate(vacancy, 0.15)).boundary_loops, 2);
  // One link between two particles is cut. Triangles across it, with the two others beside it, are possible.
  Index i = 0, j = 0;
  for (Index k = 0; k < sheet.size(); ++k) {
    if (sheet.positions[k].norm() < 1e-9) i = k;
    if ((sheet.positions[k] - Vec3(0.1, 0.0, 0.0)).norm() < 1e-9) j = k;
  }
  const AreApart apart = [&](Index a, Index b) { return (a == i && b == j) || (a == j && b == i); };
  const std::vector<WeightedTriangle> triangles = triangulateParticles(sheet.positions, sheet.normals, 0.175, apart);
  for (const WeightedTriangle& t : triangles)
    EXPECT_FALSE(std::count(t.corner, t.corner + 3, i) == 1 && std::count(t.corner, t.corner + 3, j) == 1);
}

TEST(ParticleTriangles, HexagonalSheetHasSixTrianglesAtEachInnerParticle) {
  const TestSurface sheet = makeHexagons(0.1, 0.81);
  expectTopology(sheet, 0.1 * kMaxEdge, 1, 1, 1);
  std::vector<int> count(sheet.size(), 0);
  for (const WeightedTriangle& t : triangulate(sheet, 0.1 * kMaxEdge)) {
    for (Index corner : t.corner) ++count[corner];
  }
  for (Index i = 0; i < sheet.size(); ++i) {
    const bool inner = sheet.positions[i].norm() < 0.65;
    EXPECT_TRUE(!inner || count[i] == 6) << i;
  }
}

TEST(ParticleTriangles, SquareOfAGridGetsOneDiagonalHoweverItIsTurned) {
  const int side = 12;
  for (int turn = 0; turn < 8; ++turn) {
    TestSurface sheet = cloud::makeSheet(side);
    sheet.rotate(cloud::makeRotation(0.7 * turn, 0.31 * turn));
    for (Vec3& p : sheet.positions) p = p.cast<float>().cast<double>();
    expectTopology(sheet, kMaxEdge / (side - 1), 1, 1, 1);
    EXPECT_EQ(triangulate(sheet, kMaxEdge / (side - 1)).size(), 2u * (side - 1) * (side - 1));
    EXPECT_NEAR(sumAreas(sheet, triangulate(sheet, kMaxEdge / (side - 1))), 1.0, 1e-6);  // float coordinates
  }
}

TEST(ParticleTriangles, JitteredSheetIsCoveredOnce) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const TestSurface sheet = cloud::makeSheet(20, 0.3, seed);
    expectTopology(sheet, 2.5 / 19.0, 1, 1, 1);
    EXPECT_NEAR(sumAreas(sheet, triangulate(sheet, 2.5 / 19.0)), 1.0, 1e-12);
  }
}

TEST(ParticleTriangles, SpheresAreClosed) {
  for (int n : {50, 100, 400, 1500}) {
    const TestSurface sphere = cloud::makeSphere(n);
    expectTopology(sphere, kMaxEdge * measureSpacing(sphere), 1, 0, 2);
  }
}

TEST(ParticleTriangles, NoisySpheresAreClosed) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    TestSurface sphere = cloud::makeSphere(600);
    const double spacing = measureSpacing(sphere);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> shift(-0.2 * spacing, 0.2 * spacing);
    for (Vec3& p : sphere.positions) {
      for (int axis = 0; axis < 3; ++axis) p[axis] += shift(random);
    }
    expectTopology(sphere, 2.4 * spacing, 1, 0, 2);
  }
}

// Spheres leave some quadrilaterals of such particles open; at most one of ten keeps a hole.
TEST(ParticleTriangles, NearlyAllVeryNoisySpheresAreClosed) {
  int num_closed = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    TestSurface sphere = cloud::makeSphere(600);
    const double spacing = measureSpacing(sphere);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> shift(-0.3 * spacing, 0.3 * spacing);
    for (Vec3& p : sphere.positions)
      for (int axis = 0; axis < 3; ++axis) p[axis] += shift(random);
    const std::vector<WeightedTriangle> triangles = triangulate(sphere, 2.4 * spacing);
    expectManifold(sphere, triangles);
    num_closed += measureTopology(sphere.size(), triangles).closed;
  }
  EXPECT_GE(num_closed, 18);
}

TEST(ParticleTriangles, TorusHasAHandle) {
  for (double jitter : {0.0, 0.1, 0.2}) {
    const TestSurface torus = cloud::makeTorus(60, 24, jitter);
    expectTopology(torus, 0.29, 1, 0, 0);  // cells measure 0.15 x 0.10 outside, 0.06 x 0.10 inside
  }
}

TEST(ParticleTriangles, SheetWithAHoleHasTwoLoops) {
  const TestSurface all = makeHexagons(0.1, 1.0);
  TestSurface rest;
  for (Index i = 0; i < all.size(); ++i) {
    if (all.positions[i].norm() > 0.15) rest.add(all.positions[i], all.normals[i]);
  }
  expectTopology(rest, 0.1 * kMaxEdge, 1, 2, 0);
}

TEST(ParticleTriangles, SheetsThatFaceOppositeWaysStaySeparateHoweverCloseTheyAre) {
  for (double distance : {0.02, 0.1, 0.5, 1.0}) {
    TestSurface both = makeHexagons(0.1, 0.6), other = both;
    for (Vec3& n : other.normals) n = -n;
    both.append(other, Vec3(0.03, 0.02, -0.1 * distance));
    expectTopology(both, 0.1 * kMaxEdge, 2, 2, 2);
  }
}

TEST(ParticleTriangles, SheetsThatFaceTheSameWayStaySeparateAtOneSpacing) {
  TestSurface both = makeHexagons(0.1, 0.6);
  both.append(makeHexagons(0.1, 0.6), Vec3(0.03, 0.02, 0.1));
  expectTopology(both, 0.1 * kMaxEdge, 2, 2, 2);
}

TEST(ParticleTriangles, SphereOfAnObtuseTrianglePassesThroughAllCorners) {
  // The own sphere of the longest edge would contain only the obtuse corner: the triangle would be accepted, and overlap others.
  TestSurface four;
  for (const Vec3& p : {Vec3(-1.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.5, 0.0), Vec3(0.0, -1.1, 0.0)}) {
    four.add(p, Vec3::UnitZ());
  }
  const std::vector<WeightedTriangle> triangles = triangulate(four, 10.0);
  expectManifold(four, triangles);
  ASSERT_EQ(triangles.size(), 2u);
  for (const WeightedTriangle& t : triangles) {
    EXPECT_EQ(std::count(t.corner, t.corner + 3, 2), 1);
    EXPECT_EQ(std::count(t.corner, t.corner + 3, 3), 1);  // the diagonal is 2 - 3, not 0 - 1
  }
}

TEST(ParticleTriangles, EdgesAreNoLongerThanAskedFor) {
  const TestSurface sheet = makeHexagons(0.1, 0.5);
  EXPECT_TRUE(triangulate(sheet, 0.099).empty());
  EXPECT_EQ(measureTopology(sheet.size(), triangulate(sheet, 0.099)).isolated, sheet.size());
  EXPECT_FALSE(triangulate(sheet, 0.101).empty());
}

TEST(ParticleTriangles, DoNotDependOnTheNumberOfThreads) {
  const TestSurface sheet = cloud::makeSheet(40, 0.3);
  setNumThreads(1);
  const std::vector<WeightedTriangle> one = triangulate(sheet, 2.5 / 39.0);
  for (int threads : {2, 3}) {
    setNumThreads(threads);
    const std::vector<WeightedTriangle> several = triangulate(sheet, 2.5 / 39.0);
    ASSERT_EQ(one.size(), several.size());
    for (std::size_t t = 0; t < one.size(); ++t) EXPECT_TRUE(std::equal(one[t].corner, one[t].corner + 3, several[t].corner));
  }
  setNumThreads(0);
}

TEST(ParticleTriangles, CoincidentAndCollinearParticlesSpanNothing) {
  TestSurface line;
  for (int i = 0; i < 20; ++i) line.add(Vec3(0.1 * (i / 2), 0.0, 0.0), Vec3::UnitZ());
  EXPECT_TRUE(triangulate(line, 0.3).empty());
  EXPECT_TRUE(triangulate(TestSurface(), 0.3).empty());
}

TEST(ParticleTriangles, InputThatCannotBeUsedIsRefused) {
  TestSurface sheet = makeHexagons(0.1, 0.3);
  EXPECT_THROW(triangulate(sheet, 0.0), InputError);
  EXPECT_THROW(triangulate(sheet, std::nan("")), InputError);
  TestSurface broken = sheet;
  broken.positions[3].y() = std::nan("");
  EXPECT_THROW(triangulate(broken, 0.2), InputError);
  sheet.normals.pop_back();
  EXPECT_THROW(triangulate(sheet, 0.2), InputError);
  EXPECT_THROW(linkChains(sheet.positions, sheet.normals, 0.2), InputError);
}

TEST(ParticleChains, AreLinkedHeadToTail) {
  TestSurface arc;
  for (int i = 0; i < 20; ++i) {
    const Vec3 outward(std::sin(0.1 * i), 0.0, std::cos(0.1 * i));
    arc.add(outward, outward);
  }
  const auto links = linkChains(arc.positions, arc.normals, 0.2);
  ASSERT_EQ(links.size(), 19u);
  for (Index i = 0; i < 19; ++i) EXPECT_EQ(links[i], std::make_pair(i, i + 1));
  const ParticleTopology topology = measureTopology(arc.size(), links);
  EXPECT_EQ(topology.components, 1);
  EXPECT_EQ(topology.boundary_loops, 2);
  EXPECT_EQ(topology.euler_characteristic, 1);
  EXPECT_FALSE(topology.closed);
}

TEST(ParticleChains, CircleIsClosedAndASecondOneIsAnotherComponent) {
  TestSurface circles;
  for (int i = 0; i < 60; ++i) {
    const Vec3 outward(std::sin(kPi * i / 15.0), 0.0, std::cos(kPi * i / 15.0));
    circles.add(outward + Vec3(i < 30 ? 0.0 : 2.3, 0.0, 0.0), outward);
  }
  circles.add(Vec3(0.0, 0.0, 5.0), Vec3::UnitZ());
  const ParticleTopology topology = measureTopology(circles.size(), linkChains(circles.positions, circles.normals, 0.4));
  EXPECT_EQ(topology.components, 2);
  EXPECT_EQ(topology.boundary_loops, 0);
  EXPECT_EQ(topology.euler_characteristic, 0);
  EXPECT_EQ(topology.isolated, 1);
  EXPECT_TRUE(topology.closed);
}

}  // namespace
}  // namespace deformable_surface::model
