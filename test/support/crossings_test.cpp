// The oracle that finds triangles which cut through each other.
#include "crossings.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

TEST(Crossings, AreWhereAnEdgePassesThroughATriangle) {
  Points points{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.2, 0.2, -0.1}, {0.3, 0.2, 0.1}, {2.0, 2.0, 0.1}};
  const std::vector<std::array<Index, 3>> triangles{{0, 1, 2}, {3, 4, 5}};
  EXPECT_EQ(findCrossings(points, triangles).size(), 1u);
  points[3].z() = 0.05;
  EXPECT_TRUE(findCrossings(points, triangles).empty());
  points[3].z() = 0.0;  // touches
  EXPECT_TRUE(findCrossings(points, triangles).empty());
  points[3].z() = -1e-17;
  EXPECT_EQ(findCrossings(points, triangles).size(), 1u);
}

TEST(Crossings, AreNoneOfTrianglesWithACommonVertex) {
  const Points points{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.3, 0.3, -0.1}, {0.3, 0.3, 0.1}};
  EXPECT_TRUE(findCrossings(points, {{0, 1, 2}, {0, 3, 4}}).empty());
}

}  // namespace
}  // namespace deformable_surface::test
