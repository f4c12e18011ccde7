// Generated clouds: extents, counts, edges, jitter, and the same points on every platform.
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace deformable_surface;
using namespace deformable_surface::io;
using simulation::CloudParams;
using Shape = CloudParams::Shape;

namespace {

CloudParams makeParams(Shape shape, Index points) {
  CloudParams params;
  params.shape = shape;
  params.points = points;
  return params;
}

double nearestDistance(const Points& points, std::size_t i) {
  double nearest = INFINITY;
  for (std::size_t j = 0; j < points.size(); ++j) {
    if (j != i) nearest = std::min(nearest, (points[i] - points[j]).norm());
  }
  return nearest;
}

}  // namespace

TEST(Shapes, SheetIsACentredGridWithItsEdges) {
  CloudParams params = makeParams(Shape::kSheet, 4096);
  params.size = Vec2(2.0, 2.0);
  const Points points = makeShape(params).positions;
  ASSERT_EQ(points.size(), 4096u);
  EXPECT_EQ(points.front(), Vec3(-1, -1, 0));
  EXPECT_EQ(points.back(), Vec3(1, 1, 0));
  EXPECT_NEAR(points[1].x() - points[0].x(), 2.0 / 63, 1e-15);
}

TEST(Shapes, ABarIsFilledAndItsFacesStayFlatUnderJitter) {
  CloudParams params = makeParams(Shape::kBar, 3000);
  params.size = Vec2(1.0, 0.2);
  params.height = 0.1;
  params.jitter = 0.3;
  const Points points = makeShape(params).positions;
  EXPECT_NEAR(static_cast<double>(points.size()), 3000.0, 600.0);
  Index on_faces = 0, inside = 0;
  for (const Vec3& p : points) {
    EXPECT_TRUE(p.x() >= 0.0 && p.x() <= 1.0 && std::abs(p.y()) <= 0.1 && std::abs(p.z()) <= 0.05) << p.transpose();
    const bool is_on_face = p.x() == 0.0 || p.x() == 1.0 || std::abs(p.y()) == 0.1 || std::abs(p.z()) == 0.05;
    (is_on_face ? on_faces : inside) += 1;
  }
  EXPECT_GT(on_faces, 500);
  EXPECT_GT(inside, 1000);
  EXPECT_EQ(points.front(), Vec3(0.0, -0.1, -0.05));
  EXPECT_EQ(points.back(), Vec3(1.0, 0.1, 0.05));
}

TEST(Shapes, CountsAndSpacingFollowTheSize) {
  for (const Vec2& size : {Vec2(1, 1), Vec2(3, 1), Vec2(1, 7), Vec2(100, 0.01)}) {
    for (const Index count : {4, 100, 2500}) {
      CloudParams params = makeParams(Shape::kStrip, count);
      params.size = size;
      const Points points = makeShape(params).positions;
      EXPECT_GE(points.size(), 0.75 * count) << size.transpose();
      EXPECT_LE(points.size(), 1.3 * count + 2) << size.transpose();
      double min_x = INFINITY, max_x = -INFINITY;
      for (const Vec3& p : points) {
        min_x = std::min(min_x, p.x());
        max_x = std::max(max_x, p.x());
      }
      EXPECT_EQ(min_x, 0.0);
      EXPECT_EQ(max_x, size.x());
    }
  }
}

TEST(Shapes, SpherePointsLieOnItAndApart) {
  CloudParams params = makeParams(Shape::kSphere, 1000);
  params.radius = 2.0;
  for (const double jitter : {0.0, 0.2}) {
    params.jitter = jitter;
    const Points points = makeShape(params).positions;
    ASSERT_EQ(points.size(), 1000u);
    Vec3 mean = Vec3::Zero();
    for (const Vec3& p : points) {
      EXPECT_NEAR(p.norm(), 2.0, 1e-12);
      mean += p / 1000.0;
    }
    EXPECT_LT(mean.norm(), 0.02);
    const double spacing = 2.0 * std::sqrt(4.0 * std::acos(-1.0) / 1000);
    for (std::size_t i = 0; i < points.size(); i += 50) EXPECT_GT(nearestDistance(points, i), (0.8 - 2 * jitter) * spacing);
  }
}

TEST(Shapes, TwoBarsAreJoinedAtTheSmallerXOnly) {
  CloudParams params = makeParams(Shape::kTwoBars, 4000);
  params.size = Vec2(1.0, 0.1);
  params.gap = 0.04;
  const Points points = makeShape(params).positions;
  EXPECT_NEAR(static_cast<double>(points.size()), 4000.0, 400.0);
  Index in_gap = 0;
  for (const Vec3& p : points) {
    EXPECT_EQ(p.y(), 0.0);
    EXPECT_GE(p.x(), 0.0);
    EXPECT_LE(p.x(), 1.0);
    EXPECT_LE(std::abs(p.z()), 0.12 + 1e-12);
    if (std::abs(p.z()) < 0.02 - 1e-9) {
      ++in_gap;
      EXPECT_LE(p.x(), 0.11);
    }
  }
  EXPECT_GT(in_gap, 20);
}

TEST(Shapes, TwoBarsStayApartWhenTheGapIsSmallerThanTheSpacing) {
  CloudParams params = makeParams(Shape::kTwoBars, 200);
  params.size = Vec2(1.0, 0.2);
  Index in_gap = 0;
  for (const Vec3& p : makeShape(params).positions) {
    if (std::abs(p.z()) < 0.5 * params.gap - 1e-9) {
      ++in_gap;
      EXPECT_LE(p.x(), 0.25);
    }
  }
  EXPECT_GT(in_gap, 1);
}

TEST(Shapes, JitterKeepsEdgesAndBounds) {
  CloudParams params = makeParams(Shape::kSheet, 400);
  const Points rest = makeShape(params).positions;
  params.jitter = 0.3;
  const Points points = makeShape(params).positions;
  ASSERT_EQ(points.size(), rest.size());
  const double spacing = 1.0 / 19;
  double largest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int c = 0; c < 2; ++c) {
      const bool on_edge = std::abs(rest[i][c]) == 0.5;
      EXPECT_TRUE(!on_edge || points[i][c] == rest[i][c]);
      largest = std::max(largest, std::abs(points[i][c] - rest[i][c]));
    }
  }
  EXPECT_LE(largest, 0.3 * spacing + 1e-12);
  EXPECT_GT(largest, 0.25 * spacing);
}

TEST(Shapes, SeedsGiveTheSameNumbersEverywhere) {
  CloudParams params = makeParams(Shape::kSheet, 16);
  params.jitter = 0.5;
  const Points first = makeShape(params).positions, again = makeShape(params).positions;
  EXPECT_EQ(first, again);
  params.seed = 2;
  EXPECT_NE(makeShape(params).positions, first);
  // A corner takes the first two random numbers. The first edge point moves by the third: numbers 5 and 6 of the engine.
  std::mt19937 engine(1);
  engine.discard(4);
  const double high = engine() * 2097152.0, low = engine() >> 11;
  const double unit = (high + low) / 9007199254740992.0;
  EXPECT_NEAR(first[1].x(), -0.5 + 1.0 / 3 + 0.5 / 3 * (2 * unit - 1), 1e-12);
}

TEST(Shapes, LatticeIsCentredAndAllFirstNeighboursAreEquallyFar) {
  for (const Vec2& size : {Vec2(1, 1), Vec2(3, 1), Vec2(1, 7)}) {
    CloudParams params = makeParams(Shape::kLattice, 900);
    params.size = size;
    const Points points = makeShape(params).positions;
    EXPECT_NEAR(static_cast<double>(points.size()), 900.0, 60.0) << size.transpose();
    const double spacing = points[1].x() - points[0].x();
    Vec3 low = Vec3::Constant(INFINITY), high = -low;
    std::size_t inside = 0, with_six = 0;
    for (const Vec3& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
      if (std::abs(p.x()) > 0.5 * size.x() - 0.9 * spacing || std::abs(p.y()) > 0.5 * size.y() - 1.4 * spacing) continue;
      ++inside;
      Index near = 0;
      for (const Vec3& q : points) near += std::abs((q - p).norm() - spacing) < 1e-12;
      with_six += near == 6;
    }
    EXPECT_GT(inside, 500u);
    EXPECT_EQ(with_six, inside);
    EXPECT_LT((low + high).norm(), 1e-12);
    EXPECT_NEAR(high.x(), 0.5 * size.x(), 1e-12);
    EXPECT_NEAR(high.y(), 0.5 * size.y(), 0.5 * spacing);  // half a row, and half of what it is more than that
    EXPECT_EQ(high.z(), 0.0);
  }
}

TEST(Shapes, JitterOfALatticeKeepsItsSides) {
  CloudParams params = makeParams(Shape::kLattice, 400);
  const Points rest = makeShape(params).positions;
  params.jitter = 0.3;
  const Points points = makeShape(params).positions;
  ASSERT_EQ(points.size(), rest.size());
  const double spacing = rest[1].x() - rest[0].x();
  double largest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::abs(rest[i].x()) == 0.5) {
      EXPECT_EQ(points[i].x(), rest[i].x());
    }
    if (rest[i].y() == rest.front().y() || rest[i].y() == rest.back().y()) {
      EXPECT_EQ(points[i].y(), rest[i].y());
    }
    EXPECT_EQ(points[i].z(), 0.0);
    largest = std::max(largest, (points[i] - rest[i]).cwiseAbs().maxCoeff());
  }
  EXPECT_LE(largest, 0.3 * spacing + 1e-12);
  EXPECT_GT(largest, 0.25 * spacing);
}

TEST(Shapes, ChainRunsAlongXBetweenItsEnds) {
  CloudParams params = makeParams(Shape::kChain, 21);
  params.size = Vec2(2.0, 1.0);
  for (const double jitter : {0.0, 0.3}) {
    params.jitter = jitter;
    const Points points = makeShape(params).positions;
    ASSERT_EQ(points.size(), 21u);
    EXPECT_EQ(points.front(), Vec3(-1, 0, 0));
    EXPECT_EQ(points.back(), Vec3(1, 0, 0));
    for (std::size_t i = 1; i < points.size(); ++i) {
      EXPECT_EQ(points[i].tail<2>().norm(), 0.0);
      EXPECT_NEAR(points[i].x() - points[i - 1].x(), 0.1, 0.2 * jitter + 1e-12);
    }
  }
}

TEST(Shapes, SineIsASheetWithACrestInTheMiddle) {
  CloudParams params = makeParams(Shape::kSine, 900);
  params.amplitude = 0.2;
  params.wavelength = 0.5;
  params.jitter = 0.3;
  double low = INFINITY, high = -INFINITY;
  for (const Vec3& p : makeShape(params).positions) {
    EXPECT_NEAR(p.z(), 0.2 * std::cos(2.0 * M_PI * p.x() / 0.5), 1e-12);
    EXPECT_LE(std::abs(p.x()), 0.5);
    low = std::min(low, p.z());
    high = std::max(high, p.z());
  }
  EXPECT_GT(high, 0.19);
  EXPECT_LT(low, -0.19);
}

TEST(Shapes, CapIsTheLowerPartOfASphereWithItsRim) {
  for (const double angle : {0.1, 1.0, 2.5}) {
    CloudParams params = makeParams(Shape::kCap, 1000);
    params.radius = 2.0;
    params.angle = angle;
    const Points points = makeShape(params).positions;
    EXPECT_EQ(points.size(), 1000u);
    const double spacing = 2.0 * std::sqrt(2.0 * M_PI * (1.0 - std::cos(angle)) / 1000.0);
    int on_rim = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_NEAR(points[i].norm(), 2.0, 1e-12);
      EXPECT_LE(points[i].z(), -2.0 * std::cos(angle) + 1e-12);
      on_rim += points[i].z() > -2.0 * std::cos(angle) - 1e-12;
      EXPECT_GT(nearestDistance(points, i), 0.4 * spacing);
      EXPECT_LT(nearestDistance(points, i), 1.3 * spacing);
    }
    EXPECT_NEAR(on_rim, 2.0 * M_PI * 2.0 * std::sin(angle) / spacing, 0.1 * on_rim);
  }
}

TEST(Shapes, NoShapeIsRefused) { EXPECT_THROW(makeShape(CloudParams()), InputError); }
