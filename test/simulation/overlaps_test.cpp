// Which triangles of a surface overlap at rest.
#include "../../src/simulation/overlaps.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using contact::Triangle;

bool doOverlap(const Points& rest) {
  const bool one = simulation::doOverlap(rest, {0, 1, 2}, {3, 4, 5}), other = simulation::doOverlap(rest, {3, 4, 5}, {0, 1, 2});
  EXPECT_EQ(one, other);
  return one;
}

// The triangle 0 1 2 and one that is moved by a way, m.
Points makePair(const Vec3& way) {
  Points rest = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  for (int k = 0; k < 3; ++k) rest.push_back(rest[k] + way);
  return rest;
}

TEST(Overlaps, TrianglesWithoutACommonPoint) {
  EXPECT_TRUE(doOverlap(makePair(Vec3(0.3, 0.1, 0.0))));
  EXPECT_TRUE(doOverlap(makePair(Vec3(0.3, 0.1, 0.04)))) << "nearer than a twentieth";
  EXPECT_FALSE(doOverlap(makePair(Vec3(0.3, 0.1, 0.2)))) << "another layer";
  EXPECT_FALSE(doOverlap(makePair(Vec3(1.2, 0.0, 0.0)))) << "beside";
  EXPECT_TRUE(doOverlap({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.3, 0.3, -0.5), Vec3(0.3, 0.3, 0.5), Vec3(3, 3, 0)}))
      << "an edge passes through";
  EXPECT_TRUE(doOverlap({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-2, -2, 0), Vec3(4, -1, 0), Vec3(-1, 4, 0)}))
      << "one within the other";
}

TEST(Overlaps, NeighboursOverlapWhereOneIsFoldedOntoTheOther) {
  const Points rest = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(0.2, 0.2, 0.0)};
  EXPECT_FALSE(simulation::doOverlap(rest, {0, 1, 2}, {2, 1, 3}));
  EXPECT_TRUE(simulation::doOverlap(rest, {0, 1, 2}, {1, 2, 4}));
  EXPECT_TRUE(simulation::doOverlap(rest, {0, 1, 2}, {0, 1, 3})) << "the other diagonal";
}

}  // namespace
}  // namespace deformable_surface::test
