// The outside of bodies with known volume and area.
#include "deformable_surface/model/elastic_solid/body_skin.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/model/elastic_solid/point_volumes.h"
#include "solids.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "../../src/simulation/self_contact_load.h"

namespace deformable_surface::test {
namespace {

std::vector<model::WeightedTriangle> findSkin(const Points& points) {
  const Lists neighbors = cloud::nearestNeighbors(points, 32);
  std::vector<double> empty =
      model::findPointSpacing(points, neighbors, model::findPointCells(points, neighbors, Vec3::Zero()).volume, false);
  for (double& radius : empty) radius *= model::kEmptySphere;
  return model::findBodySkin(points, neighbors, empty);
}

struct Outside {
  Index open = 0;  // edges with a triangle on one side only
  double volume = 0.0, area = 0.0;
  std::set<Index> corners;
};

Outside measure(const Points& points) {
  const simulation::ContactSkin skin(points, findSkin(points));
  Outside outside;
  std::set<std::pair<Index, Index>> sides;
  for (const contact::Triangle& t : skin.triangles) {
    const Vec3 &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
    outside.volume += a.dot(b.cross(c)) / 6.0;
    outside.area += 0.5 * (b - a).cross(c - a).norm();
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(sides.emplace(t[k], t[(k + 1) % 3]).second);
      outside.corners.insert(t[k]);
    }
  }
  for (const auto& [a, b] : sides) outside.open += sides.count({b, a}) == 0;
  return outside;
}

TEST(BodySkin, OfABoxIsClosedAndHasItsVolumeAreaAndPoints) {
  for (const double jitter : {0.0, 0.1, 0.3, 0.4}) {
    const Outside box = measure(makeBox(9, 8, 7, 0.1, jitter));
    EXPECT_EQ(box.open, 0) << jitter;
    EXPECT_NEAR(box.volume, 0.8 * 0.7 * 0.6, 1e-9) << jitter;
    EXPECT_NEAR(box.area, 2.0 * (0.8 * 0.7 + 0.7 * 0.6 + 0.8 * 0.6), 1e-9) << jitter;
    EXPECT_EQ(static_cast<Index>(box.corners.size()), 9 * 8 * 7 - 7 * 6 * 5) << jitter;
  }
}

// Without the last quarter: the hull of its points spans the concave corner.
TEST(BodySkin, OfAnLFollowsTheConcaveCorner) {
  for (const double jitter : {0.0, 0.1, 0.2}) {
    Points points;
    for (const Vec3& p : makeBox(11, 11, 5, 0.1))
      if (p.x() < 0.55 || p.y() < 0.55) points.push_back(p);
    std::mt19937 generator(4);
    const auto isInside = [](double x) { return x > 0.05 && x < 0.95; };
    for (Vec3& p : points) {
      const bool is_away = (p.x() < 0.35 && isInside(p.x())) || (p.y() < 0.35 && isInside(p.y()));
      if (is_away && isInside(p.x()) && isInside(p.y()) && p.z() > 0.05 && p.z() < 0.35)
        p += 0.1 * jitter * randomVector(generator);
    }
    const Outside corner = measure(points);
    EXPECT_NEAR(corner.volume, 0.4 * (1.0 - 0.25), 0.4 * 0.02) << jitter;
    EXPECT_LE(corner.open, 12) << jitter;
  }
}

TEST(BodySkin, OfAHollowBallHasAnInside) {
  Points points;
  for (const Vec3& p : makeBox(21, 21, 21, 0.1, 0.2)) {
    const double radius = (p - Vec3::Constant(1.0)).norm();
    if (radius < 0.95 && radius > 0.55) points.push_back(p);
  }
  for (const auto& [number, radius] : {std::make_pair(1200, 1.0), std::make_pair(300, 0.5)})
    for (const Vec3& p : makeSphere(number, radius).points) points.push_back(p + Vec3::Constant(1.0));
  const Outside ball = measure(points);
  EXPECT_NEAR(ball.volume, 4.0 / 3.0 * M_PI * (1.0 - 0.125), 0.06);
  EXPECT_NEAR(ball.area, 4.0 * M_PI * (1.0 + 0.25), 0.3);
}

TEST(BodySkin, OfTwoBoxesApartIsThatOfEach) {
  Points two = makeBox(6, 6, 6, 0.1, 0.2);
  for (const Vec3& p : makeBox(5, 6, 6, 0.1, 0.2, 2)) two.push_back(p + Vec3(0.85, 0.0, 0.0));
  const Outside outside = measure(two);
  EXPECT_EQ(outside.open, 0);
  EXPECT_NEAR(outside.volume, 0.125 + 0.1, 1e-9);
}

TEST(BodySkin, DoesNotDependOnTheNumberOfThreads) {
  const Points box = makeBox(9, 8, 7, 0.1, 0.3);
  setNumThreads(1);
  const std::vector<model::WeightedTriangle> one = findSkin(box);
  setNumThreads(3);
  const std::vector<model::WeightedTriangle> three = findSkin(box);
  setNumThreads(0);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t t = 0; t < one.size(); ++t) {
    EXPECT_TRUE(std::equal(one[t].corner, one[t].corner + 3, three[t].corner));
    EXPECT_EQ(one[t].weight, three[t].weight);
  }
}

TEST(BodySkin, OfTooFewPointsIsEmpty) {
  EXPECT_TRUE(findSkin({Vec3::Zero(), Vec3::UnitX()}).empty());
  EXPECT_TRUE(model::findBodySkin({}, {}, {}).empty());
}

}  // namespace
}  // namespace deformable_surface::test
