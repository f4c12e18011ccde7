// Components, boundaries and Euler characteristic of surfaces where they are known.
#include "deformable_surface/model/oriented_particles/particle_triangles.h"

#include <gtest/gtest.h>

namespace deformable_surface::model {
namespace {

TEST(ParticleTopology, OfATetrahedronATriangleAndALonePoint) {
  const std::vector<WeightedTriangle> faces = {{{0, 2, 1}, 1.0}, {{0, 1, 3}, 1.0}, {{1, 2, 3}, 1.0}, {{0, 3, 2}, 1.0}};
  const ParticleTopology closed = measureTopology(4, faces);
  EXPECT_EQ(closed.components, 1);
  EXPECT_EQ(closed.euler_characteristic, 2);
  EXPECT_EQ(closed.boundary_loops, 0);
  const ParticleTopology open = measureTopology(3, std::vector<WeightedTriangle>{{{0, 1, 2}, 1.0}});
  EXPECT_EQ(open.components, 1);
  EXPECT_EQ(open.euler_characteristic, 1);
  EXPECT_EQ(open.boundary_loops, 1);
}

TEST(ParticleTopology, OfTheTorusWithTheFewestPointsAndOfTwoPieces) {
  std::vector<WeightedTriangle> torus;  // seven points, each beside all others [Moebius 1861]
  for (Index i = 0; i < 7; ++i) {
    torus.push_back({{i, (i + 1) % 7, (i + 3) % 7}, 1.0});
    torus.push_back({{i, (i + 3) % 7, (i + 2) % 7}, 1.0});
  }
  const ParticleTopology one = measureTopology(8, torus);
  EXPECT_EQ(one.euler_characteristic, 0);
  EXPECT_EQ(one.genus, 1);
  EXPECT_TRUE(one.closed);
  EXPECT_EQ(one.isolated, 1);
  torus.push_back({{7, 8, 9}, 1.0});
  const ParticleTopology two = measureTopology(10, torus);
  EXPECT_EQ(two.components, 2);
  EXPECT_EQ(two.boundary_loops, 1);
  EXPECT_FALSE(two.closed);
}

TEST(ParticleTopology, OfARingAndAnArc) {
  using Links = std::vector<std::pair<Index, Index>>;
  const ParticleTopology ring = measureTopology(4, Links{{0, 1}, {1, 2}, {2, 3}, {0, 3}});
  EXPECT_EQ(ring.euler_characteristic, 0);
  EXPECT_TRUE(ring.closed);
  const ParticleTopology arc = measureTopology(4, Links{{0, 1}, {1, 2}});
  EXPECT_EQ(arc.boundary_loops, 2);
  EXPECT_EQ(arc.isolated, 1);
}

}  // namespace
}  // namespace deformable_surface::model
