#include "deformable_surface/cloud/farthest_points.h"
#include "../model/solids.h"

#include <gtest/gtest.h>

#include <set>

namespace deformable_surface::test {
namespace {

double nearestDistance(const Points& points, const std::vector<Index>& kept, const Vec3& to, Index but = -1) {
  double nearest = 1e300;
  for (Index i : kept)
    if (i != but) nearest = std::min(nearest, (points[i] - to).norm());
  return nearest;
}

// No two farthest points are closer than some radius, and every point of the cloud is within that radius of one of them.
TEST(FarthestPoints, FillABodyEvenlyAtEveryNumber) {
  const Points box = makeBox(14, 10, 10, 0.1, 0.3);
  const cloud::Simplification order = cloud::orderByDistance(box, cloud::nearestNeighbors(box, 32), 20, {});
  for (const Index target : {40, 200, 700}) {
    const std::vector<Index> kept = order.keepCount(target);
    ASSERT_EQ(static_cast<Index>(kept.size()), target);
    double apart = 1e300, cover = 0.0;
    for (Index i : kept) apart = std::min(apart, nearestDistance(box, kept, box[i], i));
    for (const Vec3& p : box) cover = std::max(cover, nearestDistance(box, kept, p));
    EXPECT_LE(cover, apart * (1.0 + 1e-9)) << target;
  }
}

TEST(FarthestPoints, AreAPrefixOfFewerOnes) {
  const Points box = makeBox(10, 8, 8, 0.1, 0.3);
  const cloud::Simplification order = cloud::orderByDistance(box, cloud::nearestNeighbors(box, 32), 10, {});
  const std::vector<Index> few = order.keepCount(50), many = order.keepCount(200);
  EXPECT_TRUE(std::includes(many.begin(), many.end(), few.begin(), few.end()));
  // The threshold is twice the distance from a point to the next.
  const std::vector<Index> kept = order.keepDiameter(0.4);
  for (Index i : kept) EXPECT_GE(nearestDistance(box, kept, box[i], i), 0.2);
}

TEST(FarthestPoints, KeepWhatIsProtectedAndAPointOfEveryPart) {
  Points points = makeBox(6, 6, 6, 0.1, 0.2);
  const Index first = static_cast<Index>(points.size());
  for (const Vec3& p : makeBox(5, 5, 5, 0.1, 0.2)) points.push_back(p + Vec3(5.0, 0.0, 0.0));
  const Lists neighbors = cloud::nearestNeighbors(points, 20);
  const std::vector<Index> kept = cloud::orderByDistance(points, neighbors, 4, {17, 30}).keepCount(4);
  const std::set<Index> all(kept.begin(), kept.end());
  EXPECT_TRUE(all.count(17) && all.count(30));
  EXPECT_GE(*all.rbegin(), first);
}

}  // namespace
}  // namespace deformable_surface::test
