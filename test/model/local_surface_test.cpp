// Visibility between particles, and the position and normal of a surface that they suggest.
#include "../../src/model/oriented_particles/local_surface.h"

#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace deformable_surface::test {
namespace {

Quaternion towards(const Vec3& normal) { return Quaternion::FromTwoVectors(Vec3::UnitZ(), normal); }

TEST(LocalSurface, SeesAlongASheetAndNotAcrossIt) {
  const Points positions{Vec3::Zero(), Vec3(1.0, 0.0, 0.2), Vec3(0.1, 0.0, 1.0), Vec3(1.0, 0.0, 0.0)};
  const Orientations orientations{Quaternion::Identity(), Quaternion::Identity(), Quaternion::Identity(),
                                  towards(-Vec3::UnitZ())};
  const model::LocalSurface surface(positions, orientations);
  EXPECT_TRUE(surface.sees(0, 1));
  EXPECT_FALSE(surface.sees(0, 2)) << "it lies above";
  EXPECT_FALSE(surface.sees(0, 3)) << "it faces the other way";
}

TEST(LocalSurface, IsClearOfAllButParentsAndThoseThatFaceTheOtherWay) {
  const Points positions{Vec3::Zero(), Vec3(1.0, 0.0, 0.0), Vec3(0.5, 0.2, 0.0)};
  const Index parents[2] = {0, 1};
  std::vector<cloud::Neighbor> found;
  Orientations orientations(3, Quaternion::Identity());
  EXPECT_FALSE(model::LocalSurface(positions, orientations).isClear(Vec3(0.5, 0.0, 0.0), Vec3::UnitZ(), 0.4, parents, found));
  EXPECT_TRUE(model::LocalSurface(positions, orientations).isClear(Vec3(0.5, 0.0, 0.0), Vec3::UnitZ(), 0.19, parents, found));
  orientations[2] = towards(-Vec3::UnitZ());
  EXPECT_TRUE(model::LocalSurface(positions, orientations).isClear(Vec3(0.5, 0.0, 0.0), Vec3::UnitZ(), 0.4, parents, found));
}

TEST(LocalSurface, IsOpenUpToAHeightAboveAndBelow) {
  const Points positions{Vec3::Zero(), Vec3(1.0, 0.0, 0.0), Vec3(0.5, 0.0, 0.3)};
  const Orientations orientations(3, Quaternion::Identity());
  const model::LocalSurface surface(positions, orientations);
  const Index parents[2] = {0, 1};
  std::vector<cloud::Neighbor> found;
  EXPECT_FALSE(surface.isOpen(Vec3(0.5, 0.0, 0.0), Vec3::UnitZ(), 0.1, 0.4, parents, found));
  EXPECT_TRUE(surface.isOpen(Vec3(0.5, 0.0, 0.0), Vec3::UnitZ(), 0.1, 0.2, parents, found));
}

// Particles on a sphere: the place found between them lies on it, with its normal.
TEST(LocalSurface, PlacesAParticleOnTheSphereOfItsNeighbours) {
  const double radius = 2.0, scale = 0.3;
  Points positions;
  Orientations orientations;
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j) {
      const Vec3 normal = Vec3(0.1 * i, 0.1 * j, 1.0).normalized();
      positions.push_back(radius * normal);
      orientations.push_back(towards(normal));
    }
  const model::LocalSurface surface(positions, orientations);
  const Index parents[2] = {24, 25};  // the middle and its neighbour
  std::vector<cloud::Neighbor> found;
  const model::Placed placed = surface.place(0.5 * (positions[24] + positions[25]), scale, parents, found);
  EXPECT_NEAR(placed.position.norm(), radius, 1e-4 * radius);
  EXPECT_GT((placed.orientation * Vec3::UnitZ()).dot(placed.position.normalized()), std::cos(2e-3));
  EXPECT_TRUE(surface.sees(24, placed));
  EXPECT_TRUE(surface.fits(placed, 0.5, found));
}

TEST(LocalSurface, RefusesWhatIsNoPlaceOrNoRotation) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(model::LocalSurface({Vec3::Zero()}, {}), InputError);
  EXPECT_THROW(model::LocalSurface({Vec3(nan, 0.0, 0.0)}, {Quaternion::Identity()}), InputError);
  EXPECT_THROW(model::LocalSurface({Vec3::Zero()}, {Quaternion(2.0, 0.0, 0.0, 0.0)}), InputError);
}

}  // namespace
}  // namespace deformable_surface::test
