// A surface without contact is told apart from one whose parts have passed through each other.
#include "../../src/simulation/passage_watch.h"

#include <gtest/gtest.h>

namespace deformable_surface::simulation {
namespace {

// Two parallel squares of n x n points, 1 m wide, one above the other by a height and displaced by a little.
Points makeLayers(Index n, double height) {
  Points points;
  for (const double z : {0.0, height})
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < n; ++j) points.emplace_back(i / (n - 1.0) + 0.1 * z, j / (n - 1.0) + 0.15 * z, z);
  return points;
}

std::vector<model::WeightedTriangle> makeTriangles(Index n) {
  std::vector<model::WeightedTriangle> triangles;
  for (Index first : {Index{0}, n * n})
    for (Index i = 0; i + 1 < n; ++i)
      for (Index j = 0; j + 1 < n; ++j) {
        const Index a = first + i * n + j;
        triangles.push_back({{a, a + n, a + n + 1}, 1.0});
        triangles.push_back({{a, a + n + 1, a + 1}, 1.0});
      }
  return triangles;
}

// The upper layer hangs through the lower one around its middle.
Points pushThrough(Points points, Index n) {
  points[n * n + n * n / 2].z() = -0.1;
  return points;
}

TEST(PassageWatch, FindsWhereALayerHasPassedThroughAnother) {
  const Points rest = makeLayers(5, 0.2);
  PassageWatch watch(rest, std::make_shared<ContactSkin>(rest, makeTriangles(5)));
  EXPECT_FALSE(watch.look(rest, nullptr));
  Points near = rest;
  near[37].z() = 0.01;
  EXPECT_FALSE(watch.look(near, nullptr));
  const auto found = watch.look(pushThrough(rest, 5), nullptr);
  ASSERT_TRUE(found);
  EXPECT_GE(found->triangles, 2);
  EXPECT_LT((found->place - Vec3(0.5, 0.5, 0.0)).norm(), 0.3);
}

TEST(PassageWatch, LeavesOutWhatIsSoAtRest) {
  const Points rest = pushThrough(makeLayers(5, 0.2), 5);
  PassageWatch watch(rest, std::make_shared<ContactSkin>(rest, makeTriangles(5)));
  EXPECT_FALSE(watch.look(rest, nullptr));
  Points lower = rest;
  lower[37].z() = -0.15;
  EXPECT_FALSE(watch.look(lower, nullptr));
  lower[25].z() = -0.1;  // a corner, far from there
  EXPECT_TRUE(watch.look(lower, nullptr));
}

TEST(PassageWatch, LeavesOutWhatIsCut) {
  const Points rest = makeLayers(5, 0.2);
  std::vector<model::WeightedTriangle> triangles = makeTriangles(5);
  PassageWatch watch(rest, std::make_shared<ContactSkin>(rest, triangles));
  const Points through = pushThrough(rest, 5);
  EXPECT_TRUE(watch.look(through, &triangles));
  triangles.resize(triangles.size() / 2);
  EXPECT_FALSE(watch.look(through, &triangles));
}

}  // namespace
}  // namespace deformable_surface::simulation
