// The relaxation between passes of growth: states that stay at rest, unevenness that it removes, and staying on the surface.
#include "deformable_surface/model/oriented_particles/relax_on_surface.h"

#include "deformable_surface/base/parallel.h"
#include "model/particle_relaxation.h"
#include "model/particle_surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace deformable_surface::model {
namespace {

double findRadiusError(const Points& positions) {
  double squares = 0.0;
  for (const Vec3& p : positions) squares += (p.norm() - 1.0) * (p.norm() - 1.0);
  return std::sqrt(squares / positions.size());
}

TEST(RelaxOnSurface, LatticesAndSpheresStayWhereTheyAre) {
  const TestSurface sheet = makeHexagons(0.1, 1.0);
  Points positions = sheet.positions;
  Orientations orientations = orientTo(sheet.normals);
  relaxOnSurface(0.1, 5, std::vector<char>(sheet.size(), 0), positions, orientations);
  for (Index i = 0; i < sheet.size(); ++i) EXPECT_LT((positions[i] - sheet.positions[i]).norm(), 1e-12);

  const TestSurface sphere = cloud::makeSphere(300);
  positions = sphere.positions;
  orientations = orientTo(sphere.normals);
  relaxOnSurface(0.22, 20, std::vector<char>(sphere.size(), 0), positions, orientations);
  // They slide along tangents, leave the sphere by the square of their motion, and return along their normals.
  EXPECT_LT(findRadiusError(positions), 1e-3);
}

TEST(RelaxOnSurface, NoiseBecomesLessAndFixedOnesStay) {
  TestSurface sphere = cloud::makeSphere(300);
  std::mt19937 generator(7);
  for (Vec3& p : sphere.positions) p *= 1.0 + 0.04 * (generator() / 4294967295.0 - 0.5);
  Points positions = sphere.positions;
  Orientations orientations = orientTo(sphere.normals);
  std::vector<char> fixed(sphere.size(), 0);
  fixed[5] = 1;
  const double before = findRadiusError(positions);
  relaxOnSurface(0.2, 20, fixed, positions, orientations);
  EXPECT_LT(findRadiusError(positions), 0.5 * before);
  EXPECT_EQ(positions[5], sphere.positions[5]);
}

TEST(RelaxOnSurface, OnlyWhatIsNearSomethingThatMovesWakes) {
  TestSurface sheet = makeHexagons(0.1, 2.0);
  const auto distances = [&](const Points& positions) {
    std::vector<double> all;
    for (const Vec3& p : positions) all.push_back((p - sheet.positions[0]).norm());
    return all;
  };
  const std::vector<double> from_first = distances(sheet.positions);
  const Index far = static_cast<Index>(std::max_element(from_first.begin(), from_first.end()) - from_first.begin());
  // The sheet is uneven at its first and at its farthest particle.
  Points positions = sheet.positions;
  for (const Index i : {Index{0}, far}) positions[i] += Vec3(0.03, 0.02, 0.01);
  const Points before = positions;
  Orientations orientations = orientTo(sheet.normals);
  std::vector<char> awake(sheet.size(), 0);
  awake[0] = 1;
  relaxOnSurface(0.1, 20, std::vector<char>(sheet.size(), 0), positions, orientations, &awake);
  EXPECT_NE(positions[0], before[0]);
  Index moved = 0;
  for (Index i = 0; i < sheet.size(); ++i) {
    moved += positions[i] != before[i];
    if (from_first[i] > 1.0) {
      EXPECT_EQ(positions[i], before[i]) << i;
    }
  }
  EXPECT_GT(moved, 5);
  EXPECT_TRUE(std::none_of(awake.begin(), awake.end(), [](char a) { return a; }));

  Points all = before;
  orientations = orientTo(sheet.normals);
  relaxOnSurface(0.1, 20, std::vector<char>(sheet.size(), 0), all, orientations);
  EXPECT_NE(all[far], before[far]);
}

TEST(RelaxOnSurface, DoesNotDependOnTheNumberOfThreads) {
  const TestSurface torus = cloud::makeTorus(24, 10, 0.15);
  const auto relax = [&](int threads) {
    setNumThreads(threads);
    Points positions = torus.positions;
    Orientations orientations = orientTo(torus.normals);
    relaxOnSurface(0.3, 5, std::vector<char>(torus.size(), 0), positions, orientations);
    return positions;
  };
  const Points one = relax(1);
  EXPECT_EQ(relax(2), one);
  EXPECT_EQ(relax(3), one);
  setNumThreads(0);
}

}  // namespace
}  // namespace deformable_surface::model
