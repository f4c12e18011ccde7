// Rows are distinguished from lattices, random points, jitter and near layers, on flat and curved surfaces.
#include "deformable_surface/cloud/row_spacing.h"

#include "../support/surfaces.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

constexpr Index kNeighbors = 32;

cloud::RowSpacing find(const Points& points) {
  return cloud::findRowSpacing(points, cloud::nearestNeighbors(points, kNeighbors));
}

double measure(const Points& points) {
  const cloud::RowSpacing spacing = find(points);
  EXPECT_EQ(spacing.groups, 1.0);
  return spacing.rows;
}

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
  EXPECT_EQ(cloud::findRowSpacing({}, Lists()).rows, 1.0);
  const Points three = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()};
  EXPECT_EQ(cloud::findRowSpacing(three, cloud::nearestNeighbors(three, 2)).rows, 1.0);
}

// Their neighbours along the row tell no more.
TEST(RowSpacing, RowsFarApartAreMoreThanTheNeighboursReach) {
  for (const double apart : {6.0, 10.0, 50.0})
    for (const double jitter : {0.0, 0.05}) EXPECT_EQ(measure(makeRows(apart, jitter)), cloud::kFarthestRows) << apart;
}

// The points again, moved several times.
Points copyShifted(const Points& points, int copies, const Vec3& shift) {
  Points all = points;
  for (int c = 1; c <= copies; ++c)
    for (const Vec3& p : points) all.push_back(p + c * shift);
  return all;
}

TEST(RowSpacing, LayersOneAboveTheOtherAreGroups) {
  for (const double apart : {0.0101, 0.02, 0.1, 0.3})
    for (const double jitter : {0.0, 0.2}) {
      const cloud::RowSpacing found = find(copyShifted(makeRows(1.0, jitter), 1, apart * Vec3::UnitZ()));
      EXPECT_EQ(found.rows, 1.0) << apart;
      // The nearest of jittered points around are nearer than the spacing.
      EXPECT_NEAR(found.groups, apart, (jitter > 0.0 ? 0.4 : 0.01) * apart) << jitter;
    }
}

TEST(RowSpacing, CopiesShiftedAlongTheSurfaceAreGroups) {
  for (const int copies : {1, 2, 4, 6}) {
    const cloud::RowSpacing found = find(copyShifted(makeRows(1.0, 0.0), copies, 0.008 * Vec3::UnitX()));
    EXPECT_EQ(found.rows, 1.0) << copies;
    // Along the surface a group is as much nearer to the next one as it is long.
    EXPECT_NEAR(found.groups, 0.008 / (1.0 - 0.008 * copies), 0.02 * 0.008) << copies;
  }
}

}  // namespace
}  // namespace deformable_surface::test
