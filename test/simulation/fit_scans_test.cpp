// Surfaces of oriented particles grown through samples of scans, with samples held and then released, and their distance from
// points that were not sampled. The scans are not shipped; each test skips without its own.
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/normals.h"
#include "deformable_surface/simulation/expectations.h"
#include "model/particle_surfaces.h"
#include "support/figures.h"

#include <random>

namespace deformable_surface::test {
namespace {

using model::TestSurface;
using simulation::SceneParams;
using simulation::Simulation;

constexpr const char* kNoData = "no real data: set DEFORMABLE_SURFACE_DATA to its folder";

// Doubles x y z nx ny nz after a text header; empty if the file is missing.
TestSurface readBinaryPly(const std::string& name, std::size_t count) {
  std::ifstream stream(sharedFolder() + "/" + name, std::ios::binary);
  TestSurface surface;
  for (std::string line; std::getline(stream, line) && line != "end_header";) {}
  double row[6];
  while (surface.positions.size() < count && stream.read(reinterpret_cast<char*>(row), sizeof(row)))
    surface.add(Vec3(row[0], row[1], row[2]), Vec3(row[3], row[4], row[5]));
  return surface;
}

// The first points that are at least this far from all points before them.
TestSurface chooseApart(const TestSurface& scan, double apart) {
  TestSurface samples;
  for (Index i = 0; i < scan.size(); ++i) {
    const auto isFar = [&](const Vec3& p) { return (p - scan.positions[i]).norm() >= apart; };
    if (std::all_of(samples.positions.begin(), samples.positions.end(), isFar)) samples.add(scan.positions[i], scan.normals[i]);
  }
  return samples;
}

struct Fit {
  double max_gap, sample_gap, rigidity;  // the last in E h a^2
  bool lets_go;
  double noise = 0.0;  // of the samples, spacings
};

Simulation growThrough(const TestSurface& samples, double spacing, const Fit& fit) {
  SceneParams p;
  p.model = "oriented_particles";
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.gravity.setZero();
  p.material.bending_rigidity = fit.rigidity * p.material.young_modulus * p.material.thickness * spacing * spacing;
  p.oriented_particles.spacing = spacing;
  p.oriented_particles.grow_surface = true;
  model::GrowthParams& growth = p.oriented_particles.growth;
  growth.min_gap = 1.6;
  growth.max_gap = fit.max_gap;
  growth.clearance = 0.65;
  growth.sample_gap = fit.sample_gap;
  growth.release_samples = fit.lets_go;
  growth.noise = fit.noise;
  growth.max_passes = 60;
  cloud::PointCloud input;
  input.positions = samples.positions;
  input.normals = samples.normals;
  input.width = static_cast<std::uint32_t>(samples.size());
  Simulation s(p, input);
  const auto hasEnded = [](const std::string& note) { return note.find("until there was no more room") != std::string::npos; };
  EXPECT_TRUE(std::any_of(s.buildNotes().begin(), s.buildNotes().end(), hasEnded));
  return s;
}

// Root mean square distance of the particles from the tangent planes of the nearest points of a denser scan, in spacings.
double measureDistance(const Simulation& s, const Points& dense, const Points& normals, double spacing) {
  const cloud::KdTree tree(dense);
  std::vector<cloud::Neighbor> nearest;
  double squares = 0.0;
  for (const Vec3& p : s.state().positions) {
    tree.nearest(p, 1, nearest);
    const Index i = nearest.front().index;
    const double height = (p - dense[i]).dot(normals[i]);
    squares += height * height;
  }
  return std::sqrt(squares / s.state().size()) / spacing;
}

double count(const char* quantity, Simulation& s) { return simulation::computeQuantity(quantity, s); }

// Distance of the particles from the unit sphere, in spacings.
struct Off {
  double mean = 0.0, root_mean_square = 0.0;
};
Off measureOff(const Points& positions, double spacing) {
  Off off;
  double squares = 0.0;
  for (const Vec3& p : positions) {
    const double distance = (p.norm() - 1.0) / spacing;
    off.mean += distance / static_cast<double>(positions.size());
    squares += distance * distance;
  }
  off.root_mean_square = std::sqrt(squares / static_cast<double>(positions.size()));
  return off;
}

// Distance of the particles from the mean distance of their neighbours (rms), in spacings: the remaining short waves of the
// noise.
double measureRoughness(const Points& positions, double spacing) {
  constexpr double kAround = 1.5;  // spacings
  const cloud::KdTree tree(positions);
  std::vector<cloud::Neighbor> near;
  double squares = 0.0;
  for (const Vec3& p : positions) {
    tree.withinRadius(p, kAround * spacing, near);
    double mean = 0.0;
    for (const cloud::Neighbor& q : near) mean += positions[q.index].norm() / static_cast<double>(near.size());
    squares += (p.norm() - mean) * (p.norm() - mean);
  }
  return std::sqrt(squares / static_cast<double>(positions.size())) / spacing;
}

// A unit sphere's samples, moved by up to a fifth of a spacing along their normals: 0.11 (rms).
TEST(FitScans, LettingANoisySphereGoClosesItKeepsItsRadiusAndTakesPartOfTheNoise) {
  TestSurface samples = chooseApart(model::readRealData("cgal_points/sphere_1k.xyz"), 0.3);
  if (samples.size() == 0) GTEST_SKIP() << kNoData;
  constexpr double kSpacing = 0.15;
  std::mt19937 generator(3);
  for (Index i = 0; i < samples.size(); ++i) {
    samples.normals[i] = samples.positions[i].normalized();
    samples.positions[i] = samples.normals[i] * (1.0 + 0.2 * kSpacing * (2.0 * (generator() / 4294967295.0) - 1.0));
  }
  const Simulation fixed = growThrough(samples, kSpacing, {5.0, 0.0, 1.0, false});
  Simulation s = growThrough(samples, kSpacing, {5.0, 0.0, 1.0, true, 0.11});
  EXPECT_EQ(count("components", s), 1.0);
  EXPECT_EQ(count("boundary_loops", s), 0.0);
  EXPECT_EQ(count("euler_characteristic", s), 2.0);
  EXPECT_EQ(count("isolated", s), 0.0);
  const Off sampled = measureOff(samples.positions, kSpacing), held = measureOff(fixed.state().positions, kSpacing),
            let_go = measureOff(s.state().positions, kSpacing);
  EXPECT_LT(held.root_mean_square, 0.8 * sampled.root_mean_square);
  EXPECT_LT(let_go.root_mean_square, held.root_mean_square);
  EXPECT_LT(measureRoughness(s.state().positions, kSpacing), 0.3 * measureRoughness(fixed.state().positions, kSpacing));
  // With the stated spacing there would be too few particles for the sphere. It was then 0.05 smaller than its samples.
  EXPECT_LT(std::abs(let_go.mean - sampled.mean), 0.03);
  // It is at rest.
  const Points before = s.state().positions;
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(s.step().ok);
  double largest = 0.0;
  for (Index i = 0; i < s.state().size(); ++i) largest = std::max(largest, (s.state().positions[i] - before[i]).norm());
  EXPECT_LT(largest, 0.01 * kSpacing);
}

// Nearest distances from 0.008 to 0.086, horns as thin as a spacing, sharp lips; open at the neck. Parts thinner than a spacing
// keep holes: about twenty with held samples, a few with released ones.
TEST(FitScans, AnUnevenlySampledHeadIsOnePieceNearItsScan) {
  const TestSurface scan = readBinaryPly("cgal_points/oni.ply", 1435);
  if (scan.size() == 0) GTEST_SKIP() << kNoData;
  constexpr double kSpacing = 0.04;
  Simulation s = growThrough(chooseApart(scan, kSpacing), kSpacing, {5.0, 1.7, 0.3, true});
  EXPECT_EQ(count("components", s), 1.0);
  EXPECT_GE(count("boundary_loops", s), 1.0);
  EXPECT_LE(count("boundary_loops", s), 6.0);
  EXPECT_LE(count("isolated", s), 8.0);
  EXPECT_LT(measureDistance(s, scan.positions, scan.normals, kSpacing), 0.3);
}

// A ring of legs and tail a few spacings thick. Neighbours in space confuse its sides; given normals separate them.
TEST(FitScans, AScannedCatWithNormalsClosesWithItsGenus) {
  const TestSurface scan = model::readRealData("cgal_points/kitten.xyz");
  if (scan.size() == 0) GTEST_SKIP() << kNoData;
  constexpr double kSpacing = 0.0285;
  Simulation s = growThrough(chooseApart(scan, 0.06), kSpacing, {5.0, 1.7, 0.3, true});
  EXPECT_EQ(count("components", s), 1.0);
  EXPECT_EQ(count("boundary_loops", s), 0.0);
  EXPECT_EQ(count("euler_characteristic", s), 0.0);
  EXPECT_EQ(count("isolated", s), 0.0);
  EXPECT_LT(measureDistance(s, scan.positions, scan.normals, kSpacing), 0.22);
}

// A range view: one side, with gaps where nothing was seen. The complete bunny gives the true surface.
TEST(FitScans, ARangeViewIsFilledUpToTheLimitAndStaysOpenBeyond) {
  const TestSurface view = model::readRealData("pcl_scans/bun0.pcd");
  const Points whole = readSharedPoints("open3d_bunny/bunnyData.pts");
  if (view.size() == 0 || whole.empty()) GTEST_SKIP() << kNoData;
  constexpr double kSpacing = 0.005;
  Simulation s = growThrough(chooseApart(view, kSpacing), kSpacing, {2.5, 0.0, 0.3, true});
  // The far ear is separate, with a gap wider than the limit. There is no hole besides the three outlines.
  EXPECT_EQ(count("components", s), 3.0);
  EXPECT_EQ(count("boundary_loops", s), 3.0);
  EXPECT_EQ(count("euler_characteristic", s), 3.0);
  EXPECT_LE(count("isolated", s), 10.0);
  const Points normals = cloud::estimateNormals(whole, cloud::nearestNeighbors(whole, 12));
  EXPECT_LT(measureDistance(s, whole, normals, kSpacing), 0.35);
}

}  // namespace
}  // namespace deformable_surface::test
