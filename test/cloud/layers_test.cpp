// Normals of stacked layers by a vote of the points around, and what leads from one layer to another.
#include "deformable_surface/cloud/layers.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_surface::test {
namespace {

constexpr Index kAround = 32;

// Layers of 16 x 16 points, a spacing of 1.
Points makeLayers(int layers, double gap, double jitter) {
  std::mt19937 engine(11);
  const auto draw = [&] { return jitter * (engine() / 2147483648.0 - 1.0); };
  Points points;
  for (int k = 0; k < layers; ++k)
    for (int i = 0; i < 16; ++i)
      for (int j = 0; j < 16; ++j) {
        const double x = i + draw(), y = j + draw();
        points.emplace_back(x, y, gap * k);
      }
  return points;
}

double findShareUpright(const Points& normals) {
  const auto isUpright = [](const Vec3& n) { return std::abs(n.z()) > 0.95; };
  return static_cast<double>(std::count_if(normals.begin(), normals.end(), isUpright)) / static_cast<double>(normals.size());
}

TEST(Layers, OnlySteepLinksBetweenEndsThatFaceAlikeLeadUp) {
  const Vec3 up = Vec3::UnitZ(), aside = Vec3::UnitX();
  EXPECT_TRUE(cloud::leadsUp(Vec3(0.3, 0.0, 1.0), up, up));
  EXPECT_TRUE(cloud::leadsUp(Vec3(0.3, 0.0, 1.0), up, -up)) << "of any sides";
  EXPECT_FALSE(cloud::leadsUp(Vec3(1.0, 0.0, 0.8), up, up));
  EXPECT_FALSE(cloud::leadsUp(Vec3(0.0, 0.0, 1.0), up, aside)) << "around an edge";
}

TEST(Layers, MostPointsDecideWhichWayLayersLie) {
  for (const int layers : {3, 4, 5})
    for (const double gap : {1.0, 1.2}) {
      const Points points = makeLayers(layers, gap, 0.2);
      const Lists in_space = cloud::nearestNeighbors(points, kAround);
      const Points single = cloud::estimateNormalsInSpace(points, in_space).normals;
      EXPECT_LT(findShareUpright(single), 0.8);
      const cloud::AgreedNormals agreed = cloud::agreeOnNormals(points, in_space, single);
      EXPECT_EQ(findShareUpright(agreed.normals), 1.0) << layers << ' ' << gap;
      EXPECT_EQ(findShareUpright(agreed.at_creases), 1.0) << layers << ' ' << gap;
    }
}

TEST(Layers, AtAnEdgeThePointsAgreeOnTwoNormals) {
  Points points;  // two faces that meet at x = 7
  for (int i = 0; i < 16; ++i)
    for (int j = 0; j < 16; ++j) points.emplace_back(std::min(i, 7), j, std::max(i - 7, 0));
  const Lists in_space = cloud::nearestNeighbors(points, kAround);
  const cloud::AgreedNormals agreed =
      cloud::agreeOnNormals(points, in_space, cloud::estimateNormalsInSpace(points, in_space).normals);
  for (Index i = 0; i < static_cast<Index>(points.size()); ++i) {
    const double x = std::abs(agreed.normals[i].x()), z = std::abs(agreed.normals[i].z());
    EXPECT_GT(std::max(x, z), 0.999) << i;
    if (points[i].x() < 4.0) EXPECT_EQ(agreed.at_creases[i], agreed.normals[i]);
    if (points[i].x() == 6.0) EXPECT_NEAR(agreed.at_creases[i].dot(agreed.normals[i]), 0.0, 1e-9) << i;
  }
}

TEST(Layers, NeighboursAboveAndLostOnesAreCounted) {
  const Points points = makeLayers(2, 1.0, 0.0);
  const Index n = static_cast<Index>(points.size());
  const Points normals(n, Vec3::UnitZ());
  const Lists in_space = cloud::nearestNeighbors(points, kAround);
  EXPECT_EQ(cloud::countLinkedUp(points, normals, in_space), n);
  Lists within;
  for (Index i = 0; i < n; ++i) {
    std::copy_if(in_space.begin(i), in_space.end(i), std::back_inserter(within.items),
                 [&](Index j) { return points[j].z() == points[i].z(); });
    within.offsets.push_back(static_cast<Index>(within.items.size()));
  }
  EXPECT_EQ(cloud::countLinkedUp(points, normals, within), 0);
  EXPECT_GE(cloud::countLost(points, normals, in_space, within).up, n);
  EXPECT_EQ(cloud::countLost(points, normals, within, within).up, 0);
  EXPECT_EQ(cloud::countLost(points, normals, within, within).along, 0);
}

TEST(Layers, ResultsHaveTheSameBitsOnTwoThreads) {
  const Points points = makeLayers(3, 1.2, 0.4);
  const Lists in_space = cloud::nearestNeighbors(points, kAround);
  const Points single = cloud::estimateNormalsInSpace(points, in_space).normals;
  const cloud::AgreedNormals one = cloud::agreeOnNormals(points, in_space, single);
  setNumThreads(2);
  const cloud::AgreedNormals two = cloud::agreeOnNormals(points, in_space, single);
  setNumThreads(0);
  EXPECT_EQ(one.normals, two.normals);
  EXPECT_EQ(one.at_creases, two.at_creases);
}

TEST(Layers, SizesThatDoNotFitAreRefused) {
  const Points points = makeLayers(1, 1.0, 0.0);
  EXPECT_THROW(cloud::agreeOnNormals(points, cloud::nearestNeighbors(points, 4), Points(3, Vec3::UnitZ())), InputError);
  EXPECT_THROW(cloud::countLinkedUp(points, Points(), cloud::nearestNeighbors(points, 4)), InputError);
}

}  // namespace
}  // namespace deformable_surface::test
