// Parts, loops and what fills them up.
#include "deformable_surface/contact/outlines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace deformable_surface::contact {
namespace {

using Triangle = std::array<Index, 3>;

struct Mesh {
  Points points;
  std::vector<Triangle> triangles;
};

// Squares of 1 m, two triangles each, where there is one: (column, row).
Mesh makeGrid(Index columns, Index rows, const std::function<bool(Index, Index)>& exists) {
  Mesh mesh;
  for (Index j = 0; j <= rows; ++j)
    for (Index i = 0; i <= columns; ++i) mesh.points.emplace_back(i, j, 0.0);
  for (Index j = 0; j < rows; ++j)
    for (Index i = 0; i < columns; ++i) {
      if (!exists(i, j)) continue;
      const Index a = j * (columns + 1) + i, b = a + columns + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  return mesh;
}

double areaOf(const Outlines& outlines, const Points& points) {
  double area = 0.0;
  for (const Triangle& t : outlines.triangles) area += 0.5 * (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).z();
  return area;
}

Index numLoops(const Outlines& outlines) { return static_cast<Index>(outlines.loops.size()) - 1; }
Index sizeOf(const Outlines& outlines, Index loop) { return outlines.loops[loop + 1].first - outlines.loops[loop].first; }

TEST(Outlines, OfASheet) {
  const Mesh mesh = makeGrid(5, 3, [](Index, Index) { return true; });
  const Outlines outlines = findOutlines(mesh.points, mesh.triangles);
  ASSERT_EQ(outlines.numParts(), 1);
  EXPECT_EQ(outlines.points.size(), 24u);
  EXPECT_EQ(outlines.triangles, mesh.triangles);
  ASSERT_EQ(numLoops(outlines), 1);
  EXPECT_EQ(sizeOf(outlines, 0), 16);
  EXPECT_FALSE(outlines.loops[0].is_hole);
  EXPECT_EQ(outlines.loops[0].middle, -1);
}

TEST(Outlines, OfTwoParts) {
  const Mesh mesh = makeGrid(7, 2, [](Index i, Index) { return i != 3; });
  const Outlines outlines = findOutlines(mesh.points, mesh.triangles);
  ASSERT_EQ(outlines.numParts(), 2);
  EXPECT_EQ(outlines.parts[1].first_point, 12);
  EXPECT_EQ(outlines.parts[1].first_triangle, 12);
  EXPECT_EQ(numLoops(outlines), 2);
  EXPECT_EQ(outlines.triangles.size(), 24u);
  for (Index k = 0; k < 12; ++k) EXPECT_LT(mesh.points[outlines.points[k]].x(), 3.5);
}

TEST(Outlines, FillUpSmallHolesOnly) {
  // Two neighbouring squares: a hole of six points.
  const Mesh small = makeGrid(6, 5, [](Index i, Index j) { return j != 2 || (i != 2 && i != 3); });
  const Outlines filled = findOutlines(small.points, small.triangles);
  EXPECT_EQ(numLoops(filled), 1);
  EXPECT_DOUBLE_EQ(areaOf(filled, small.points), 30.0);
  // Three: a hole of eight, of which only the ends are filled up, as its edges there run towards its middle.
  const Mesh large = makeGrid(7, 5, [](Index i, Index j) { return j != 2 || i < 2 || i > 4; });
  const Outlines open = findOutlines(large.points, large.triangles);
  EXPECT_EQ(numLoops(open), 2);
  EXPECT_LT(areaOf(open, large.points), 34.0);
}

TEST(Outlines, AreNoneOfManyPartsOrLonePointsWithoutAHole) {
  const Mesh apart = makeGrid(19, 19, [](Index i, Index j) { return i % 2 == 0 && j % 2 == 0; });
  EXPECT_EQ(findOutlines(apart.points, apart.triangles).numParts(), 0);
  const Mesh hollow = makeGrid(7, 7, [](Index i, Index j) { return i < 2 || i > 4 || j < 2 || j > 4; });
  EXPECT_EQ(findOutlines(hollow.points, hollow.triangles).numParts(), 0);  // four points in one hole
}

TEST(Outlines, HaveAPointInTheMiddleOfAHole) {
  const Mesh mesh = makeGrid(6, 6, [](Index i, Index j) { return i < 2 || i > 3 || j < 2 || j > 3; });
  const Outlines outlines = findOutlines(mesh.points, mesh.triangles);
  ASSERT_EQ(outlines.numParts(), 1);
  ASSERT_EQ(numLoops(outlines), 2);
  const Index hole = outlines.loops[0].is_hole ? 0 : 1;
  EXPECT_TRUE(outlines.loops[hole].is_hole);
  EXPECT_FALSE(outlines.loops[1 - hole].is_hole);
  EXPECT_EQ(outlines.loops[hole].middle, 3 * 7 + 3);
  EXPECT_EQ(sizeOf(outlines, hole), 8);
  EXPECT_EQ(outlines.points.size(), 49u);
}

TEST(Outlines, FillUpWhatRecedes) {
  // Two bars with a bridge: from the middle, one cannot see the ends of the bars.
  const Mesh mesh = makeGrid(9, 7, [](Index i, Index j) { return j < 2 || j > 4 || i == 4; });
  Points points;
  std::vector<Index> number(mesh.points.size(), -1);
  std::vector<Triangle> triangles = mesh.triangles;
  for (Triangle& t : triangles)
    for (Index& v : t) {
      if (number[v] < 0) {
        number[v] = static_cast<Index>(points.size());
        points.push_back(mesh.points[v]);
      }
      v = number[v];
    }
  const Outlines outlines = findOutlines(points, triangles);
  ASSERT_EQ(outlines.numParts(), 1);
  EXPECT_EQ(numLoops(outlines), 1);
  EXPECT_GT(outlines.triangles.size(), triangles.size() + 8);
  // Nothing is filled twice.
  EXPECT_LE(areaOf(outlines, points), 63.0);
  for (const Triangle& t : outlines.triangles)
    EXPECT_GT((points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).z(), 0.1);
}

// Seen from the middle, the long sides of a strip recede at its ends. Thin triangles between uneven points there would limit the
// proof more than that does.
TEST(Outlines, DoNotFillUpAnUnevenSideWithThinTriangles) {
  Mesh mesh = makeGrid(24, 3, [](Index, Index) { return true; });
  for (std::size_t k = 0; k < mesh.points.size(); ++k)
    mesh.points[k] += Vec3(0.05 * std::sin(12.9 * static_cast<double>(k)), 0.05 * std::sin(78.2 * static_cast<double>(k)), 0.0);
  const Outlines outlines = findOutlines(mesh.points, mesh.triangles);
  ASSERT_EQ(numLoops(outlines), 1);
  EXPECT_GT(sizeOf(outlines, 0), 40);  // of 54
  for (std::size_t t = mesh.triangles.size(); t < outlines.triangles.size(); ++t) {
    const Vec3 &a = mesh.points[outlines.triangles[t][0]], &b = mesh.points[outlines.triangles[t][1]],
               &c = mesh.points[outlines.triangles[t][2]];
    EXPECT_GT((b - a).cross(c - a).z() / std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()}), 0.05) << t;
  }
}

TEST(Outlines, CloseLoopsWhereTheyMeet) {
  // Two holes with a corner in common, and a third one with a corner on the boundary.
  const Mesh mesh = makeGrid(8, 8, [](Index i, Index j) {
    return !(i == 2 && j == 2) && !(i == 3 && j == 3) && !(i == 6 && j >= 6 && j < 7) && !(i == 7 && j == 7);
  });
  const Outlines outlines = findOutlines(mesh.points, mesh.triangles);
  // The corner point (8, 8) has no triangle and lies in no hole.
  EXPECT_EQ(outlines.numParts(), 0);
  Mesh rest = makeGrid(8, 8, [](Index i, Index j) { return !(i == 2 && j == 2) && !(i == 3 && j == 3) && !(i == 0 && j == 6); });
  const Outlines filled = findOutlines(rest.points, rest.triangles);
  ASSERT_EQ(filled.numParts(), 1);
  EXPECT_EQ(numLoops(filled), 1);
  EXPECT_GE(areaOf(filled, rest.points), 63.0);
}

TEST(Outlines, AreNoneOfAClosedSurfaceOrOfNothing) {
  const Points corners{{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.0, 0.1, 0.0}, {0.0, 0.0, 0.1}};
  EXPECT_EQ(findOutlines(corners, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}).numParts(), 0);
  EXPECT_EQ(findOutlines(corners, {}).numParts(), 0);
  EXPECT_EQ(findOutlines({}, {}).numParts(), 0);
  // Three triangles at one edge.
  EXPECT_EQ(findOutlines(corners, {{0, 1, 2}, {0, 1, 3}}).numParts(), 0);
}

}  // namespace
}  // namespace deformable_surface::contact
