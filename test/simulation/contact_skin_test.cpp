// The triangles of contact lie over the whole surface once: also where neighbours do not agree about the model's triangles.
#include "../../src/simulation/contact_skin.h"

#include "clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "../support/crossings.h"

namespace deformable_surface::test {
namespace {

using contact::Triangle;
using simulation::ContactSkin;

// Closed lines of edges that have a triangle on one side only.
int countBorders(const std::vector<Triangle>& triangles) {
  std::set<std::pair<Index, Index>> edges;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(edges.emplace(t[k], t[(k + 1) % 3]).second) << "an edge of two triangles on one side";
  std::map<Index, Index> parent;
  const auto find = [&](Index i) {
    while (parent[i] != i) i = parent[i];
    return i;
  };
  for (const auto& [from, to] : edges) {
    if (edges.count({to, from}) > 0) continue;
    parent.emplace(from, from);
    parent.emplace(to, to);
    parent[find(from)] = find(to);
  }
  return static_cast<int>(
      std::count_if(parent.begin(), parent.end(), [](const auto& entry) { return entry.first == entry.second; }));
}

// Layers of n x n points of 0.3 m, some spacings apart.
cloud::PointCloud makeLayers(int n, int layers, double spacings, double jitter, std::uint32_t seed) {
  std::mt19937 engine(seed);
  const auto draw = [&] { return jitter * (engine() / 2147483648.0 - 1.0); };
  const double spacing = 0.3 / (n - 1);
  Points points;
  for (int layer = 0; layer < layers; ++layer)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const double x = i + draw(), y = j + draw();
        points.emplace_back(spacing * x, spacing * y, spacing * spacings * layer);
      }
  return asCloud(points);
}

TEST(ContactSkin, LayersThatAreNearEachOtherHaveNoHoles) {
  simulation::SceneParams params;
  params.accuracy.estimate = false;
  params.simplification.method = cloud::SimplificationMethod::kNone;
  for (const double spacings : {1.0, 1.5, 2.0, 4.0})
    for (const double jitter : {0.0, 0.2, 0.3}) {
      const simulation::Simulation s(params, makeLayers(14, 2, spacings, jitter, 5));
      const Points& rest = s.state().positions;
      const ContactSkin skin(rest, trianglesOf(s.model()));
      EXPECT_EQ(countBorders(skin.triangles), 2) << spacings << ' ' << jitter;
      EXPECT_TRUE(findCrossings(rest, skin.triangles).empty()) << spacings << ' ' << jitter;
    }
}

TEST(ContactSkin, WhatFillsAHoleIsWholeWhileTheSurfaceBelowIs) {
  simulation::SceneParams params;
  params.accuracy.estimate = false;
  params.simplification.method = cloud::SimplificationMethod::kNone;
  const simulation::Simulation s(params, makeLayers(14, 2, 1.5, 0.3, 5));
  const std::vector<model::WeightedTriangle>& all = trianglesOf(s.model());
  const ContactSkin skin(s.state().positions, all);
  std::set<Triangle> given;
  for (const model::WeightedTriangle& t : all) given.insert({t.corner[0], t.corner[1], t.corner[2]});
  const auto isNew = [&](const Triangle& t) { return given.count(t) == 0; };
  ASSERT_TRUE(std::any_of(skin.triangles.begin(), skin.triangles.end(), isNew));
  const std::vector<char> at_rest = skin.findWhole(all), without = skin.findWhole({});
  EXPECT_EQ(std::count(at_rest.begin(), at_rest.end(), 1), static_cast<long>(skin.triangles.size()));
  EXPECT_EQ(std::count(without.begin(), without.end(), 1), 0);
}

// A square of two triangles, and a larger upright one at a corner of it that passes through them and is left out.
TEST(ContactSkin, TheShareWithoutIsThatOnWhichNoTriangleLies) {
  const Points rest = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0), Vec3(0.6, 0.3, 1), Vec3(0.6, 0.3, -1)};
  const std::vector<model::WeightedTriangle> square = {{{0, 1, 2}, 1.0}, {{0, 2, 3}, 1.0}};
  EXPECT_EQ(ContactSkin(rest, square).share_without, 0.0);
  std::vector<model::WeightedTriangle> all = square;
  all.push_back({{0, 1, 3}, 0.5});  // lies on the square
  EXPECT_EQ(ContactSkin(rest, all).share_without, 0.0);
  all.push_back({{0, 4, 5}, 1.0});
  const double area = 0.5 * (rest[4] - rest[0]).cross(rest[5] - rest[0]).norm();
  EXPECT_NEAR(ContactSkin(rest, all).share_without, area / (1.25 + area), 1e-12);
}

}  // namespace
}  // namespace deformable_surface::test
