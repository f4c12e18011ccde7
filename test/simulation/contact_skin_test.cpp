// The triangles of contact lie over the whole surface once: also where neighbours do not agree about the model's triangles.
#include "../../src/simulation/contact_skin.h"

#include "clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "../../src/simulation/skin_holes.h"
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

double areaOf(const Points& rest, const std::vector<Triangle>& triangles) {
  double area = 0.0;
  for (const Triangle& t : triangles) area += 0.5 * (rest[t[1]] - rest[t[0]]).cross(rest[t[2]] - rest[t[0]]).norm();
  return area;
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

// A square of four corners and its middle. The model's triangles overlap: 0 1 4 is missing.
//   3 2
//    4
//   0 1
const Points kSquare = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0), Vec3(0.5, 0.4, 0)};

TEST(ContactSkin, AHoleIsFilledWhereTheSurfaceGoesOn) {
  const std::vector<Triangle> layer = {{1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const auto fill = [&](const std::vector<Triangle>& surface) {
    std::vector<Triangle> filled;
    for (const simulation::Filling& filling : simulation::fillHoles(kSquare, layer, surface)) filled.push_back(filling.triangle);
    return filled;
  };
  EXPECT_TRUE(fill({}).empty()) << "nothing lies there: the border goes in";
  const std::vector<Triangle> filled = fill({{0, 1, 2}});
  ASSERT_EQ(filled.size(), 1u);
  EXPECT_EQ(std::set<Index>(filled[0].begin(), filled[0].end()), (std::set<Index>{0, 1, 4}));
  EXPECT_EQ(countBorders({layer[0], layer[1], layer[2], filled[0]}), 1);
  EXPECT_NEAR(areaOf(kSquare, {layer[0], layer[1], layer[2], filled[0]}), 1.0, 1e-12);
  EXPECT_TRUE(fill({{0, 2, 1}}).empty()) << "the other side of a layer";
  EXPECT_EQ(fill({{0, 1, 4}}), (std::vector<Triangle>{{0, 1, 4}}));
}

TEST(ContactSkin, NothingIsFilledOverAPointWithoutTriangles) {
  Points with_point = kSquare;
  with_point.emplace_back(0.5, 0.15, 0.0);
  const std::vector<Triangle> layer = {{1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  EXPECT_TRUE(simulation::fillHoles(with_point, layer, {{0, 1, 2}}).empty());
  with_point.back().z() = 0.5;  // another layer
  EXPECT_EQ(simulation::fillHoles(with_point, layer, {{0, 1, 2}}).size(), 1u);
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

}  // namespace
}  // namespace deformable_surface::test
