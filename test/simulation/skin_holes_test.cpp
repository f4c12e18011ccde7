// A hole in a layer of triangles is filled where the surface goes on, and nowhere else.
#include "../../src/simulation/skin_holes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace deformable_surface::test {
namespace {

using contact::Triangle;

double areaOf(const Points& rest, const std::vector<Triangle>& triangles) {
  double area = 0.0;
  for (const Triangle& t : triangles) area += 0.5 * (rest[t[1]] - rest[t[0]]).cross(rest[t[2]] - rest[t[0]]).norm();
  return area;
}

// A square of four corners and its middle. The model's triangles overlap: 0 1 4 is missing.
//   3 2
//    4
//   0 1
const Points kSquare = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0), Vec3(0.5, 0.4, 0)};

TEST(SkinHoles, AHoleIsFilledWhereTheSurfaceGoesOn) {
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
  EXPECT_NEAR(areaOf(kSquare, {layer[0], layer[1], layer[2], filled[0]}), 1.0, 1e-12);
  EXPECT_TRUE(fill({{0, 2, 1}}).empty()) << "the other side of a layer";
  EXPECT_EQ(fill({{0, 1, 4}}), (std::vector<Triangle>{{0, 1, 4}}));
}

TEST(SkinHoles, NothingIsFilledOverAPointWithoutTriangles) {
  Points with_point = kSquare;
  with_point.emplace_back(0.5, 0.15, 0.0);
  const std::vector<Triangle> layer = {{1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  EXPECT_TRUE(simulation::fillHoles(with_point, layer, {{0, 1, 2}}).empty());
  with_point.back().z() = 0.5;  // another layer
  EXPECT_EQ(simulation::fillHoles(with_point, layer, {{0, 1, 2}}).size(), 1u);
}

// A hexagon around a hole of six edges: new triangles between its edges, where one triangle of the surface lies under all of it.
TEST(SkinHoles, AHoleOfSixEdgesIsFilledOnce) {
  Points rest;
  for (const double radius : {1.0, 2.0})
    for (int k = 0; k < 6; ++k) rest.emplace_back(radius * std::cos(k * M_PI / 3.0), radius * std::sin(k * M_PI / 3.0), 0.0);
  rest.insert(rest.end(), {Vec3(-9.0, -5.0, 0.0), Vec3(9.0, -5.0, 0.0), Vec3(0.0, 10.0, 0.0)});
  std::vector<Triangle> layer;
  for (Index k = 0; k < 6; ++k) {
    layer.push_back({k, 6 + k, 6 + (k + 1) % 6});
    layer.push_back({k, 6 + (k + 1) % 6, (k + 1) % 6});
  }
  std::vector<Triangle> filled;
  for (const simulation::Filling& filling : simulation::fillHoles(rest, layer, {{12, 13, 14}})) {
    filled.push_back(filling.triangle);
    for (const Triangle& beneath : filling.beneath) EXPECT_EQ(beneath, (Triangle{12, 13, 14}));
  }
  EXPECT_EQ(filled.size(), 4u);
  EXPECT_NEAR(areaOf(rest, filled), 1.5 * std::sqrt(3.0), 1e-12);
}

// A hole of three edges over two triangles of the surface. Its places are all on the larger of these; the middle of the edge 0 1
// is on the other one.
TEST(SkinHoles, WhatFillsAHoleLiesOnWhatIsBelowItsEdges) {
  const Points rest = {Vec3(0, 0, 0),  Vec3(1, 0, 0),       Vec3(0.5, 1, 0),    Vec3(0.5, -1, 0),    Vec3(2, 1, 0),
                       Vec3(-1, 1, 0), Vec3(-0.1, 0.05, 0), Vec3(1.1, 0.05, 0), Vec3(0.5, -0.05, 0), Vec3(0.5, 2, 0)};
  const std::vector<Triangle> layer = {{1, 0, 3}, {2, 1, 4}, {0, 2, 5}}, surface = {{6, 8, 7}, {6, 7, 9}};
  const std::vector<simulation::Filling> filled = simulation::fillHoles(rest, layer, surface);
  ASSERT_EQ(filled.size(), 1u);
  const auto lieOn = [&](const Triangle& t) { return std::count(filled[0].beneath.begin(), filled[0].beneath.end(), t); };
  EXPECT_EQ(lieOn(surface[0]), 1);
  EXPECT_EQ(lieOn(surface[1]), 6);
}

}  // namespace
}  // namespace deformable_surface::test
