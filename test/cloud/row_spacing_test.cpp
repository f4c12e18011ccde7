// Rows are distinguished from lattices, random points and jitter, on flat and curved surfaces.
#include "deformable_surface/cloud/row_spacing.h"

#include "../support/surfaces.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

constexpr Index kNeighbors = 32;

double measure(const Points& points) { return cloud::findRowSpacing(points, cloud::nearestNeighbors(points, kNeighbors)); }

// 60 x so many points. The rows are so many times farther apart than the points in a row.
Points makeRows(double apart, double jitter) { return makeSheet(60, 40, 59.0, 39.0 * apart, jitter).points; }

TEST(RowSpacing, EvenAndRandomPointsHaveNone) {
  for (const double jitter : {0.0, 0.1, 0.3, 0.45}) EXPECT_EQ(measure(makeRows(1.0, jitter)), 1.0) << jitter;
  EXPECT_EQ(measure(makeSphere(1000, 1.0).points), 1.0);
  std::mt19937 generator(1);
  Points random;
  for (int i = 0; i < 2000; ++i) random.emplace_back(uniform(generator), uniform(generator), 0.0);
  EXPECT_EQ(measure(random), 1.0);
}

TEST(RowSpacing, RowsAreMeasured) {
  for (const double apart : {2.0, 3.0, 4.0})
    for (const double jitter : {0.0, 0.1, 0.3}) EXPECT_NEAR(measure(makeRows(apart, jitter)), apart, 0.25 * apart) << jitter;
}

TEST(RowSpacing, RowsOnACylinderAreMeasured) {
  Points rolled = makeRows(3.0, 0.1);
  for (Vec3& p : rolled) p = Vec3(p.x(), 40.0 * std::sin(p.y() / 40.0), 40.0 * std::cos(p.y() / 40.0));
  EXPECT_NEAR(measure(rolled), 3.0, 0.75);
}

TEST(RowSpacing, FewPointsAreInNoRows) {
  EXPECT_EQ(cloud::findRowSpacing({}, Lists()), 1.0);
  const Points three = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()};
  EXPECT_EQ(cloud::findRowSpacing(three, cloud::nearestNeighbors(three, 2)), 1.0);
}

}  // namespace
}  // namespace deformable_surface::test
