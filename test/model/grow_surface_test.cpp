// Growth until it ends: sparse samples become closed surfaces, holes are filled up to the limit, edges stay, limits are reported;
// and real scans.
#include "deformable_surface/model/oriented_particles/grow_surface.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/oriented_particles/particle_triangles.h"
#include "model/particle_relaxation.h"
#include "model/particle_surfaces.h"

#include <gtest/gtest.h>

namespace deformable_surface::model {
namespace {

// After growth no gap of d_max remains, so this edge length spans the surface.
constexpr double kMaxEdge = 2.5;

GrownSurface growFrom(const TestSurface& samples, double spacing, const GrowthParams& params,
                      const Relaxation& relax = relaxNothing) {
  return growSurface(samples.positions, orientTo(samples.normals), spacing, params, relax);
}

Points normalsOf(const GrownSurface& surface) {
  Points normals;
  for (const Eigen::Quaterniond& q : surface.orientations) normals.push_back(q * Vec3::UnitZ());
  return normals;
}

ParticleTopology measure(const GrownSurface& surface, double spacing) {
  return measureTopology(static_cast<Index>(surface.positions.size()),
                         triangulateParticles(surface.positions, normalsOf(surface), kMaxEdge * spacing));
}

GrowthParams upTo(double max_gap) {
  GrowthParams params;
  params.max_gap = max_gap;
  return params;
}

TestSurface cutHole(const TestSurface& all, double radius) {
  TestSurface rest;
  for (Index i = 0; i < all.size(); ++i) {
    if (all.positions[i].norm() > radius) rest.add(all.positions[i], all.normals[i]);
  }
  return rest;
}

TEST(GrowSurface, HoleOfThreeSpacingsIsFilledIfTheLimitAllows) {
  const TestSurface sheet = cutHole(makeHexagons(0.1, 1.0), 0.15);  // seven particles are missing
  const GrownSurface kept = growFrom(sheet, 0.1, upTo(2.9));
  EXPECT_EQ(measure(kept, 0.08).boundary_loops, 2);
  EXPECT_TRUE(kept.added.empty());
  const GrownSurface filled = growFrom(sheet, 0.1, upTo(3.1));
  EXPECT_EQ(filled.added.size(), 7u);
  EXPECT_EQ(measure(filled, 0.08).boundary_loops, 1);
  EXPECT_EQ(filled.end, GrowthEnd::kNoRoom);
}

TEST(GrowSurface, SparseSamplesOfASphereBecomeAClosedSurface) {
  for (int n : {12, 20, 40, 80}) {
    const GrownSurface grown = growFrom(cloud::makeSphere(n), 0.2, upTo(6.0));
    EXPECT_EQ(grown.end, GrowthEnd::kNoRoom);
    const ParticleTopology topology = measure(grown, 0.2);
    EXPECT_TRUE(topology.closed) << n;
    EXPECT_EQ(topology.components, 1) << n;
    EXPECT_EQ(topology.isolated, 0) << n;
    EXPECT_EQ(topology.euler_characteristic, 2) << n;
    // 4 pi at hexagonal density are 363 particles. Gaps too small for a particle make it looser. Nowhere is it denser than the
    // clearance.
    EXPECT_GT(grown.positions.size(), 363u / 2);
    EXPECT_LT(grown.positions.size(), 363u / (0.7 * 0.7));
    // The sampled radius is also reached between samples: a tenth of a spacing is far below the sagitta of their chords.
    for (const Vec3& p : grown.positions) EXPECT_NEAR(p.norm(), 1.0, 0.1 * 0.2) << n;
  }
}

TEST(GrowSurface, SparseSamplesOfATorusKeepItsHandle) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const GrownSurface grown = growFrom(cloud::makeTorus(24, 10, 0.15, seed), 0.12, upTo(4.0), makeRelaxation(0.12, 10));
    EXPECT_EQ(grown.end, GrowthEnd::kNoRoom);
    const ParticleTopology topology = measure(grown, 0.12);
    EXPECT_TRUE(topology.closed);
    EXPECT_EQ(topology.components, 1);
    EXPECT_EQ(topology.euler_characteristic, 0);
    EXPECT_EQ(topology.genus, 1);
    for (const Vec3& p : grown.positions) {
      EXPECT_NEAR(std::hypot(std::hypot(p.x(), p.y()) - 1.0, p.z()), 0.4, 0.15 * 0.12);
    }
  }
}

TEST(GrowSurface, EdgesOfAnOpenSheetStay) {
  for (double jitter : {0.0, 0.3}) {
    const TestSurface sheet = cloud::makeSheet(20, jitter);
    const GrownSurface grown = growFrom(sheet, 1.0 / 19.0, upTo(4.0));
    EXPECT_EQ(grown.end, GrowthEnd::kNoRoom);
    for (const Vec3& p : grown.positions) {
      EXPECT_GE(p.minCoeff(), -1e-12);
      EXPECT_LE(p.maxCoeff(), 1.0 + 1e-12);
    }
    EXPECT_EQ(measure(grown, 1.0 / 19.0).boundary_loops, 1);
  }
}

TEST(GrowSurface, EdgeGrowsByTheRowsItMay) {
  const TestSurface sheet = makeHexagons(0.1, 0.55);
  for (Index rows : {1, 2, 5}) {
    GrowthParams params;
    params.edge_rows = rows;
    const GrownSurface grown = growFrom(sheet, 0.1, params);
    EXPECT_EQ(grown.end, GrowthEnd::kNoRoom);
    double reach = 0.0;
    for (const Vec3& p : grown.positions) reach = std::max(reach, p.norm());
    EXPECT_GT(reach, 0.5 + 0.08 * rows);
    EXPECT_LE(reach, 0.55 + 0.1 * rows + 1e-9);
    EXPECT_EQ(measure(grown, 0.08).boundary_loops, 1);
  }
}

TEST(GrowSurface, OneParticleGrowsRowsOfHexagons) {
  GrowthParams params;
  params.edge_rows = 6;
  const TestSurface one = makePositionsOf({Vec3(0.0, 0.0, 1.0)});
  const GrownSurface grown = growFrom(one, 0.1, params);
  EXPECT_EQ(grown.positions.size(), 1u + 3u * 6u * 7u);
  EXPECT_EQ(grown.passes, 6);
  EXPECT_TRUE(growFrom(one, 0.1, upTo(4.0)).added.empty());
}

TEST(GrowSurface, OppositeSheetsThatLieCloseAreFilledApart) {
  TestSurface sheet = cutHole(makeHexagons(0.1, 0.7), 0.15), both = sheet;
  for (Vec3& n : sheet.normals) n = -n;
  both.append(sheet, Vec3(0.0, 0.0, -0.04));
  const GrownSurface grown = growFrom(both, 0.1, upTo(3.1));
  EXPECT_EQ(grown.added.size(), 14u);
  const ParticleTopology topology = measure(grown, 0.08);
  EXPECT_EQ(topology.components, 2);
  EXPECT_EQ(topology.boundary_loops, 2);
}

TEST(GrowSurface, ChainsOfSamplesClose) {
  GrowthParams params = upTo(9.0);
  params.chain = true;
  TestSurface samples;
  for (int i = 0; i < 9; ++i) {
    const double angle = 2.0 * kPi * (i + 0.2 * (i % 3)) / 9.0;
    const Vec3 outward(std::sin(angle), 0.0, std::cos(angle));
    samples.add(outward, outward);
  }
  const GrownSurface grown = growFrom(samples, 0.1, params);
  const Index n = static_cast<Index>(grown.positions.size());
  const ParticleTopology topology = measureTopology(n, linkChains(grown.positions, normalsOf(grown), kMaxEdge * 0.1));
  EXPECT_TRUE(topology.closed);
  EXPECT_EQ(topology.components, 1);
  EXPECT_EQ(topology.isolated, 0);
  for (const Vec3& p : grown.positions) {
    EXPECT_EQ(p.y(), 0.0);
    EXPECT_NEAR(p.norm(), 1.0, 1e-3);  // the sagitta of the samples' chords is 0.06 to 0.1
  }
}

TEST(GrowSurface, SamplesStayFixedUntilTheyAreReleased) {
  const TestSurface samples = cloud::makeSphere(40);
  const Index n = samples.size();
  std::vector<Index> num_fixed;
  bool all_move = false;
  const Relaxation watch = [&](Points& positions, Orientations&, const std::vector<char>& fixed, std::vector<char>* awake) {
    ASSERT_EQ(fixed.size(), positions.size());
    if (awake) {
      ASSERT_EQ(awake->size(), positions.size());
      EXPECT_TRUE((*awake).back()) << "new ones move";
      awake->assign(awake->size(), 0);
    }
    all_move = !awake;
    num_fixed.push_back(static_cast<Index>(std::count(fixed.begin(), fixed.end(), 1)));
  };
  GrowthParams params = upTo(4.0);
  const GrownSurface grown = growFrom(samples, 0.2, params, watch);
  ASSERT_EQ(static_cast<Index>(num_fixed.size()), grown.passes + 1);
  EXPECT_EQ(num_fixed.front(), n);
  EXPECT_EQ(num_fixed[grown.passes - 1], n);
  EXPECT_EQ(num_fixed.back(), 0);
  EXPECT_TRUE(all_move);
  for (Index i = 0; i < n; ++i) EXPECT_EQ(grown.positions[i], samples.positions[i]);

  num_fixed.clear();
  params.fix_samples = false;
  growFrom(samples, 0.2, params, watch);
  EXPECT_EQ(std::count(num_fixed.begin(), num_fixed.end(), 0), static_cast<std::ptrdiff_t>(num_fixed.size()));
}

// Each relaxation moves samples outwards by a tenth of their stated noise.
TEST(GrowSurface, NoisySamplesAreRelaxedUntilTheyHaveMovedAsFarAsTheirNoise) {
  const TestSurface samples = cloud::makeSphere(40);
  constexpr double kSpacing = 0.2;
  Index releases = 0;
  const Relaxation raise = [&](Points& positions, Orientations& orientations, const std::vector<char>& fixed,
                               std::vector<char>*) {
    if (std::count(fixed.begin(), fixed.end(), 1) > 0) return;
    ++releases;
    for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += 0.1 * kSpacing * (orientations[i] * Vec3::UnitZ());
  };
  for (const auto& [noise, expected] : {std::pair(0.0, 1), std::pair(0.05, 1), std::pair(0.25, 3), std::pair(1.0, 6)}) {
    GrowthParams params = upTo(4.0);
    params.noise = noise;
    releases = 0;
    growFrom(samples, kSpacing, params, raise);
    EXPECT_EQ(releases, expected) << noise;
  }
}

TEST(GrowSurface, MaximaEndGrowthAndAreReported) {
  GrowthParams params;
  params.edge_rows = 50;
  params.max_passes = 3;
  const TestSurface one = makePositionsOf({Vec3::Zero()});
  GrownSurface grown = growFrom(one, 0.1, params);
  EXPECT_EQ(grown.end, GrowthEnd::kMaxPasses);
  EXPECT_EQ(grown.positions.size(), 37u);
  params.max_passes = 100;
  params.max_particles = 100;
  grown = growFrom(one, 0.1, params);
  EXPECT_EQ(grown.end, GrowthEnd::kMaxParticles);
  EXPECT_EQ(grown.positions.size(), 91u);
}

TEST(GrowSurface, DoesNotDependOnTheNumberOfThreads) {
  const TestSurface samples = cloud::makeTorus(24, 10, 0.15);
  setNumThreads(1);
  const GrownSurface one = growFrom(samples, 0.12, upTo(4.0), makeRelaxation(0.12, 3));
  for (int threads : {2, 3}) {
    setNumThreads(threads);
    EXPECT_EQ(growFrom(samples, 0.12, upTo(4.0), makeRelaxation(0.12, 3)).positions, one.positions);
  }
  setNumThreads(0);
}

TEST(GrowSurface, PositionsWithoutOrientationsAreRefused) {
  EXPECT_THROW(growSurface({Vec3::Zero()}, {}, 0.1, {}, relaxNothing), InputError);
  EXPECT_TRUE(growSurface({}, {}, 0.1, {}, relaxNothing).positions.empty());
}

constexpr const char* kNoData = "no real data: set DEFORMABLE_SURFACE_DATA to its folder";

// The choice of samples matters: the sets differ by the point of the scan where the choice begins (docs/oriented_particles.md).
TEST(GrowSurface, SparseSamplesOfARealScanBecomeASurfaceOfItsGenus) {
  const TestSurface scan = readRealData("cgal_points/kitten.xyz");
  if (scan.size() == 0) GTEST_SKIP() << kNoData;
  const double spacing = 0.0285;
  const cloud::KdTree tree(scan.positions);
  int num_closed = 0;
  for (const Index start : {0, 4}) {
    TestSurface samples;
    for (Index k = 0; k < scan.size(); ++k) {
      const Index i = (k * (start > 0 ? 7919LL : 1LL) + start) % scan.size();
      const auto isFar = [&](const Vec3& p) { return (p - scan.positions[i]).norm() >= 0.06; };
      if (std::all_of(samples.positions.begin(), samples.positions.end(), isFar)) samples.add(scan.positions[i], scan.normals[i]);
    }
    GrowthParams params = upTo(5.0);
    params.min_gap = 1.6;
    params.clearance = 0.65;
    params.sample_gap = 1.7;
    const GrownSurface grown = growFrom(samples, spacing, params, makeRelaxation(spacing, 20));
    EXPECT_EQ(grown.end, GrowthEnd::kNoRoom) << start;
    const ParticleTopology topology = measure(grown, 0.74 * spacing);  // edges as long as those that are displayed
    EXPECT_EQ(topology.components, 1) << start;
    EXPECT_EQ(topology.isolated, 0) << start;
    num_closed += topology.closed && topology.genus == 1;

    // Distance from the tangent planes of the scan. Released particles rest where their neighbours are co-circular: 0.14
    // spacings.
    std::vector<cloud::Neighbor> nearest;
    double sum = 0.0;
    for (const Vec3& p : grown.positions) {
      tree.nearest(p, 1, nearest);
      const Index i = nearest[0].index;
      const double height = (p - scan.positions[i]).dot(scan.normals[i]);
      sum += height * height;
    }
    EXPECT_LT(std::sqrt(sum / grown.positions.size()), 0.2 * spacing) << start;
  }
  EXPECT_EQ(num_closed, 2);
}

TEST(GrowSurface, FullySampledRealSphereStaysClosed) {
  const TestSurface scan = readRealData("cgal_points/sphere_1k.xyz");
  if (scan.size() == 0) GTEST_SKIP() << kNoData;
  const double spacing = measureSpacing(scan);
  const GrownSurface grown = growFrom(scan, spacing, upTo(4.0));
  EXPECT_LT(grown.added.size(), 0.02 * scan.size());
  const ParticleTopology topology = measure(grown, spacing);
  EXPECT_TRUE(topology.closed);
  EXPECT_EQ(topology.euler_characteristic, 2);
  for (const NewParticle& p : grown.added) EXPECT_NEAR(p.position.norm(), 1.0, 0.02);  // the samples' radii are 0.983 to 1.008
}

TEST(GrowSurface, HolesOfARangeViewAreFilledUpToTheLimit) {
  const TestSurface scan = readRealData("pcl_scans/bun0.pcd");
  if (scan.size() == 0) GTEST_SKIP() << kNoData;
  const double spacing = measureSpacing(scan);
  const ParticleTopology before =
      measureTopology(scan.size(), triangulateParticles(scan.positions, scan.normals, kMaxEdge * spacing));
  const GrownSurface grown = growFrom(scan, spacing, upTo(2.5), makeRelaxation(spacing, 20));
  EXPECT_EQ(grown.end, GrowthEnd::kNoRoom);
  const ParticleTopology after = measure(grown, spacing);
  EXPECT_GT(before.boundary_loops, 10);
  EXPECT_LE(2 * after.boundary_loops, before.boundary_loops);
  EXPECT_LE(after.isolated, before.isolated);
  for (const NewParticle& p : grown.added) {
    double nearest = HUGE_VAL;
    for (const Vec3& q : scan.positions) nearest = std::min(nearest, (q - p.position).norm());
    EXPECT_LT(nearest, 2.25 * spacing);  // no farther than rows of half the limit and one more may reach
  }
}

}  // namespace
}  // namespace deformable_surface::model
