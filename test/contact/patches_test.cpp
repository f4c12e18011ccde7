// How a surface is divided into patches, and how far their points move relative to each other.
#include "deformable_surface/contact/patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "folded_sheets.h"

namespace deformable_surface::contact {
namespace {

std::vector<Edge> listEdges(const std::vector<Triangle>& triangles) {
  std::set<Edge> edges;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  return {edges.begin(), edges.end()};
}

std::vector<Index> listVertices(const Points& points) {
  std::vector<Index> vertices(points.size());
  std::iota(vertices.begin(), vertices.end(), Index{0});
  return vertices;
}

TEST(Patches, HoldEachVertexEdgeAndTriangleOnce) {
  const test::Sheets sheets = test::makeSheets(2, 11, 0.004, 0.001);
  const std::vector<Edge> edges = listEdges(sheets.triangles);
  const Patches patches(sheets.points, listVertices(sheets.points), edges, sheets.triangles);
  EXPECT_GT(patches.size(), 10);
  std::vector<int> of_vertex(sheets.points.size(), 0), of_edge(edges.size(), 0), of_triangle(sheets.triangles.size(), 0);
  for (Index p = 0; p < patches.size(); ++p) {
    Box box = patches.boundOf(p, sheets.points);
    box.extend(box.max() + Vec3::Constant(1e-12)).extend(box.min() - Vec3::Constant(1e-12));
    patches.visitVertices(p, [&](Index v) {
      ++of_vertex[v];
      EXPECT_TRUE(box.contains(sheets.points[v]));
    });
    patches.visitEdges(p, [&](Index e) {
      ++of_edge[e];
      for (const Index v : edges[e]) EXPECT_TRUE(box.contains(sheets.points[v]));
    });
    patches.visitTriangles(p, [&](Index t) {
      ++of_triangle[t];
      for (const Index v : sheets.triangles[t]) EXPECT_TRUE(box.contains(sheets.points[v]));
    });
    // Compact: a patch of a dozen vertices is a small part of the sheets, which are 0.1 m wide.
    EXPECT_LT(box.diagonal().norm(), 0.08);
  }
  for (const std::vector<int>& counts : {of_vertex, of_edge, of_triangle})
    EXPECT_EQ(std::count(counts.begin(), counts.end(), 1), static_cast<std::ptrdiff_t>(counts.size()));
}

TEST(Patches, BoundTheRelativeWaysOfTheirPoints) {
  const test::Sheets sheets = test::makeSheets(1, 9, 0.0, 0.001);
  const Patches patches(sheets.points, listVertices(sheets.points), listEdges(sheets.triangles), sheets.triangles);
  Points to = sheets.points;
  std::mt19937 generator(5);
  for (Vec3& p : to) p += Vec3(0.3, -0.2, 0.1) + 0.01 * test::randomVector(generator);
  std::vector<Patches::Ways> ways;
  patches.measureWays(sheets.points, to, ways);
  ASSERT_EQ(static_cast<Index>(ways.size()), patches.size());
  const auto wayOf = [&](Index v) -> Vec3 { return to[v] - sheets.points[v]; };
  const double largest = findLargestRelativeWay(sheets.points, to);
  for (Index p = 0; p < patches.size(); ++p)
    for (Index q = 0; q < patches.size(); ++q) {
      double way = 0.0;
      patches.visitTriangles(p, [&](Index t) {
        patches.visitTriangles(q, [&](Index u) {
          for (const Index v : sheets.triangles[t])
            for (const Index w : sheets.triangles[u]) way = std::max(way, (wayOf(v) - wayOf(w)).norm());
        });
      });
      const double bound = ways[p].findRelative(ways[q]);
      EXPECT_GE(bound, way);
      EXPECT_LE(bound, 2.0 * way + 1e-12);
      EXPECT_LE(bound, largest);
    }
}

TEST(Patches, CommonMotionIsNoRelativeWay) {
  const test::Sheets sheets = test::makeSheets(1, 5, 0.0, 0.001);
  const Patches patches(sheets.points, listVertices(sheets.points), listEdges(sheets.triangles), sheets.triangles);
  Points to = sheets.points;
  for (Vec3& p : to) p += Vec3(0.5, 0.25, -0.125);
  std::vector<Patches::Ways> ways;
  patches.measureWays(sheets.points, to, ways);
  for (const Patches::Ways& one : ways) EXPECT_LT(one.findRelative(ways.front()), 1e-15);
  EXPECT_LT(findLargestRelativeWay(sheets.points, to), 1e-15);
}

TEST(LargestRelativeWay, IsThatOfTheBoxAroundAllWaysForAnyNumberOfPoints) {
  std::mt19937 generator(9);
  for (int n = 1; n < 14; ++n) {
    Points from(n), to(n);
    Box box;
    for (int i = 0; i < n; ++i) {
      from[i] = test::randomVector(generator);
      to[i] = test::randomVector(generator);
      box.extend(to[i] - from[i]);
    }
    EXPECT_DOUBLE_EQ(findLargestRelativeWay(from, to), box.diagonal().norm()) << n;
  }
}

}  // namespace
}  // namespace deformable_surface::contact
