// The inside of surfaces: winding numbers of closed and open spheres, and the points that fill them.
#include "deformable_surface/cloud/interior.h"

#include "../support/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace deformable_surface::cloud {
namespace {

// A unit sphere with even points; share: the part of it that exists, from the top.
SurfaceDipoles makeSphereDipoles(Index n, double share = 1.0) {
  const test::Surface sphere = test::makeSphere(n, 1.0);
  Points positions, normals;
  for (const Vec3& p : sphere.points)
    if (p.z() >= 1.0 - 2.0 * share) {
      positions.push_back(p);
      normals.push_back(p.normalized());
    }
  std::vector<Index> owner(positions.size());
  std::iota(owner.begin(), owner.end(), Index{0});
  return gatherDipoles(positions, normals, std::vector<double>(positions.size(), 4.0 * kPi / n), owner,
                       static_cast<Index>(positions.size()));
}

TEST(WindingNumber, IsOneInsideAndZeroOutside) {
  const SurfaceDipoles sphere = makeSphereDipoles(2000);
  for (const double r : {0.0, 0.5, 0.85}) EXPECT_NEAR(findWindingNumber(sphere, Vec3(0.0, 0.6 * r, 0.8 * r)), 1.0, 0.01) << r;
  for (const double r : {1.15, 1.5, 4.0}) EXPECT_NEAR(findWindingNumber(sphere, Vec3(0.0, 0.6 * r, 0.8 * r)), 0.0, 0.01) << r;
}

// The solid angle of the existing part over that of a sphere: one half, seen from the middle of a hemisphere.
TEST(WindingNumber, IsInBetweenWhereASurfaceIsOpen) {
  EXPECT_NEAR(findWindingNumber(makeSphereDipoles(2000, 0.5), Vec3::Zero()), 0.5, 0.01);
}

TEST(WindingNumber, IsKeptByPointsThatStandForOthers) {
  const test::Surface sphere = test::makeSphere(4000, 1.0);
  std::vector<Index> owner;
  Points normals;
  for (const Vec3& p : sphere.points) {
    normals.push_back(p.normalized());
    owner.push_back((p.x() > 0.0) + 2 * (p.y() > 0.0) + 4 * (p.z() > 0.0));
  }
  const SurfaceDipoles eight = gatherDipoles(sphere.points, normals, std::vector<double>(4000, 4.0 * kPi / 4000), owner, 8);
  EXPECT_EQ(eight.places.size(), 8u);
  // Of octants: area vectors of sqrt(3) pi / 4 at a distance of sqrt(3) / 2.
  EXPECT_NEAR(findWindingNumber(eight, Vec3::Zero()), 2.0 / std::sqrt(3.0), 0.01);
}

TEST(FillSurface, PutsALatticeInsideThatKeepsClearOfTheSurface) {
  const test::Surface sphere = test::makeSphere(2000, 1.0);
  const double spacing = std::sqrt(4.0 * kPi / 2000);
  const Interior interior = fillSurface(makeSphereDipoles(2000), sphere.points, spacing);
  EXPECT_EQ(interior.doubtful, 0.0);
  // The number of lattice cubes in the ball that remains. The layer near the surface is uncertain, because there is room between
  // the surface points.
  const double most = 4.0 / 3.0 * kPi / std::pow(spacing, 3), least = most * std::pow(1.0 - 0.6 * spacing, 3);
  EXPECT_GT(static_cast<double>(interior.points.size()), 0.97 * least);
  EXPECT_LT(static_cast<double>(interior.points.size()), most);
  for (const Vec3& p : interior.points) {
    EXPECT_LT(p.norm(), 1.0);
    for (const Vec3& q : sphere.points) ASSERT_GT((p - q).norm(), 0.6 * spacing);
  }
}

TEST(FillSurface, DoesNotMindWhichSideTheNormalsAreOn) {
  const test::Surface sphere = test::makeSphere(500, 1.0);
  const double spacing = std::sqrt(4.0 * kPi / 500);
  SurfaceDipoles inverted = makeSphereDipoles(500);
  for (Vec3& a : inverted.areas) a = -a;
  EXPECT_EQ(fillSurface(inverted, sphere.points, spacing).points,
            fillSurface(makeSphereDipoles(500), sphere.points, spacing).points);
}

TEST(FillSurface, TellsOfSurfacesThatDoNotCloseAndOfNormalsThatDoNotAgree) {
  const double spacing = std::sqrt(4.0 * kPi / 2000);
  const SurfaceDipoles hemisphere = makeSphereDipoles(2000, 0.5);
  EXPECT_GT(fillSurface(hemisphere, hemisphere.places, spacing).doubtful, 0.3);
  SurfaceDipoles mixed = makeSphereDipoles(2000);
  for (std::size_t i = 0; i < mixed.areas.size(); ++i)
    if (mixed.places[i].x() > 0.0) mixed.areas[i] = -mixed.areas[i];
  EXPECT_GT(fillSurface(mixed, mixed.places, spacing).doubtful, 0.3);
}

}  // namespace
}  // namespace deformable_surface::cloud
