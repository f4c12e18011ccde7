// Cubic patches on triangles: flat surfaces, spheres, and where patches meet.
#include "deformable_surface/model/curved_triangles.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/model/oriented_particles/particle_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::test {
namespace {

using model::CurvedTriangles;
using model::curveTriangles;
using model::WeightedTriangle;

// A unit sphere of 8 pieces^2 flat triangles.
CurvedTriangles makeSphere(Index pieces) {
  const Points corners{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitX(), -Vec3::UnitY(), -Vec3::UnitZ()};
  std::vector<WeightedTriangle> triangles;
  for (const Index x : {0, 3})
    for (const Index y : {1, 4})
      for (const Index z : {2, 5}) {
        const bool is_turned = corners[x].cross(corners[y]).dot(corners[z]) < 0.0;
        triangles.push_back({{x, is_turned ? z : y, is_turned ? y : z}, 1.0});
      }
  CurvedTriangles sphere = curveTriangles(corners, corners, triangles, pieces);
  for (Vec3& p : sphere.positions) p.normalize();
  sphere.normals = sphere.positions;
  return sphere;
}

// The largest angle between a triangle and the normals at its corners, rad.
double measureTurn(const CurvedTriangles& s) {
  double turn = 0.0;
  for (const WeightedTriangle& t : s.triangles) {
    const auto& [a, b, c] = t.corner;
    const Vec3 across = (s.positions[b] - s.positions[a]).cross(s.positions[c] - s.positions[a]).normalized();
    for (const Index corner : t.corner) turn = std::max(turn, std::acos(std::min(1.0, across.dot(s.normals[corner]))));
  }
  return turn;
}

TEST(CurvedTriangles, APlaneStaysFlat) {
  const Vec3 normal = Vec3(1.0, 2.0, 3.0).normalized(), x = normal.unitOrthogonal(), y = normal.cross(x);
  const Points corners{Vec3::Zero(), x, 0.3 * x + y, 1.4 * x + 0.8 * y};
  const CurvedTriangles s = curveTriangles(corners, Points(4, normal), {{{0, 1, 2}, 1.0}, {{1, 3, 2}, 0.5}}, 7);
  ASSERT_EQ(s.triangles.size(), 2u * 49u);
  double area = 0.0;
  for (const WeightedTriangle& t : s.triangles) {
    const auto& [a, b, c] = t.corner;
    const double part = 0.5 * (s.positions[b] - s.positions[a]).cross(s.positions[c] - s.positions[a]).dot(normal);
    EXPECT_GT(part, 0.0);
    area += part;
  }
  EXPECT_NEAR(area, 0.5 + 0.5 * (corners[3] - corners[1]).cross(corners[2] - corners[1]).dot(normal), 1e-14);
  for (std::size_t i = 0; i < s.positions.size(); ++i) {
    EXPECT_NEAR(s.positions[i].dot(normal), 0.0, 1e-15);
    EXPECT_NEAR((s.normals[i] - normal).norm(), 0.0, 1e-15);
  }
}

TEST(CurvedTriangles, CornersKeepTheirBitsAndOnePieceIsTheTriangle) {
  const CurvedTriangles coarse = makeSphere(3);
  for (const Index pieces : {1, 4}) {
    const CurvedTriangles fine = curveTriangles(coarse.positions, coarse.normals, coarse.triangles, pieces);
    for (std::size_t i = 0; i < coarse.positions.size(); ++i) {
      EXPECT_EQ(fine.positions[i], coarse.positions[i]);
      EXPECT_EQ(fine.normals[i], coarse.normals[i]);
    }
    ASSERT_EQ(fine.triangles.size(), coarse.triangles.size() * static_cast<std::size_t>(pieces * pieces));
    if (pieces > 1) continue;
    EXPECT_EQ(fine.positions.size(), coarse.positions.size());
    for (std::size_t t = 0; t < coarse.triangles.size(); ++t) {
      const auto &a = coarse.triangles[t].corner, &b = fine.triangles[t].corner;
      EXPECT_TRUE(std::is_permutation(std::begin(a), std::end(a), std::begin(b)));
    }
  }
}

// Flat triangles, seen in the middles of their edges: second order. Patches: fourth; their normals third.
TEST(CurvedTriangles, ASphereIsMetWithTheFourthOrder) {
  double flat[3] = {}, curved[3] = {}, turned[3] = {};
  for (int k = 0; k < 3; ++k) {
    const CurvedTriangles coarse = makeSphere(4 << k);
    const CurvedTriangles fine = curveTriangles(coarse.positions, coarse.normals, coarse.triangles, 6);
    for (const WeightedTriangle& t : coarse.triangles)
      for (int i = 0; i < 3; ++i)
        flat[k] = std::max(flat[k], 1.0 - 0.5 * (coarse.positions[t.corner[i]] + coarse.positions[t.corner[(i + 1) % 3]]).norm());
    for (std::size_t i = 0; i < fine.positions.size(); ++i) {
      curved[k] = std::max(curved[k], std::abs(fine.positions[i].norm() - 1.0));
      turned[k] = std::max(turned[k], (fine.normals[i] - fine.positions[i].normalized()).norm());
    }
    EXPECT_LT(curved[k], 3.0 * flat[k] * flat[k]) << k;
  }
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(std::log2(flat[k] / flat[k + 1]), 2.0, 0.3) << k;
    EXPECT_NEAR(std::log2(curved[k] / curved[k + 1]), 4.0, 0.5) << k;
    EXPECT_GT(std::log2(turned[k] / turned[k + 1]), 2.0) << k;
  }
}

TEST(CurvedTriangles, PatchesShareTheirEdgesAndFaceAsTheirNormals) {
  const CurvedTriangles coarse = makeSphere(3);
  const CurvedTriangles fine = curveTriangles(coarse.positions, coarse.normals, coarse.triangles, 5);
  const model::ParticleTopology topology = model::measureTopology(static_cast<Index>(fine.positions.size()), fine.triangles);
  EXPECT_TRUE(topology.closed);
  EXPECT_EQ(topology.euler_characteristic, 2);
  EXPECT_EQ(topology.isolated, 0);
  EXPECT_LT(measureTurn(fine), 0.35 * measureTurn(coarse));
}

TEST(CurvedTriangles, ValuesAreLinearBetweenCorners) {
  const Vec3 slope(1.0, 2.0, 3.0);
  const Points corners{Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3(1.0, 1.0, 0.0)};
  std::vector<double> values;
  for (const Vec3& p : corners) values.push_back(slope.dot(p));
  const CurvedTriangles s = curveTriangles(corners, Points(4, Vec3::UnitZ()), {{{0, 1, 2}, 1.0}, {{1, 3, 2}, 1.0}}, 6, values);
  ASSERT_EQ(s.values.size(), s.positions.size());
  for (std::size_t i = 0; i < s.values.size(); ++i) EXPECT_NEAR(s.values[i], slope.dot(s.positions[i]), 1e-14);
}

TEST(CurvedTriangles, RefusesWhatDoesNotFit) {
  const Points corners(3, Vec3::UnitX());
  EXPECT_THROW(curveTriangles(corners, corners, {}, 0), InputError);
  EXPECT_THROW(curveTriangles(corners, {}, {}, 1), InputError);
  EXPECT_THROW(curveTriangles(corners, corners, {}, 1, {0.0}), InputError);
}

}  // namespace
}  // namespace deformable_surface::test
