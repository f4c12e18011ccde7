#include "deformable_surface/geometry/convex_cell.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using geometry::ConvexCell;

TEST(ConvexCell, IsACubeAtFirst) {
  ConvexCell cell;
  cell.reset(0.5);
  EXPECT_NEAR(cell.volume(), 1.0, 1e-15);
}

TEST(ConvexCell, LosesWhatIsBehindAPlane) {
  ConvexCell cell;
  cell.reset(0.5);
  cell.cut(Vec3(2.0, 0.0, 0.0), 0.0);
  EXPECT_NEAR(cell.volume(), 0.5, 1e-14);
  cell.cut(Vec3(0.0, 1.0, 1.0), 0.0);
  EXPECT_NEAR(cell.volume(), 0.25, 1e-14);
  // A corner: a sixth of the product of the legs.
  cell.reset(0.5);
  cell.cut(Vec3(1.0, 1.0, 1.0), 1.2);
  EXPECT_NEAR(cell.volume(), 1.0 - std::pow(0.3, 3) / 6.0, 1e-14);
}

TEST(ConvexCell, IsNotCutByAPlaneThatOnlyTouchesIt) {
  ConvexCell cell;
  cell.reset(0.5);
  const std::size_t corners = cell.corners().size();
  cell.cut(Vec3(1.0, 1.0, 0.0), 1.0);
  cell.cut(Vec3(1.0, 1.0, 1.0), 1.5);
  cell.cut(Vec3(1.0, 0.0, 0.0), 0.5);
  EXPECT_EQ(cell.corners().size(), corners);
}

TEST(ConvexCell, IsEmptyBehindAPlaneThatTakesEverything) {
  ConvexCell cell;
  cell.reset(0.5);
  cell.cut(Vec3(1.0, 0.0, 0.0), -0.6);
  EXPECT_EQ(cell.volume(), 0.0);
  cell.cut(Vec3(0.0, 1.0, 0.0), 0.0);
  EXPECT_EQ(cell.volume(), 0.0);
}

// The cell of many planes tangent to a sphere is little larger than the sphere.
TEST(ConvexCell, ApproachesASphereByTangentPlanes) {
  ConvexCell cell;
  cell.reset(2.0);
  const int n = 400;
  for (int i = 0; i < n; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / n, r = std::sqrt(1.0 - z * z), angle = M_PI * (3.0 - std::sqrt(5.0)) * i;
    cell.cut(Vec3(r * std::cos(angle), r * std::sin(angle), z), 1.0);
  }
  const double sphere = 4.0 / 3.0 * M_PI;
  EXPECT_GT(cell.volume(), sphere);
  EXPECT_LT(cell.volume(),
            1.02 * sphere);  // facets of area 4 pi / n are farther by half their squared radius, 4 / n, at their rims
}

}  // namespace
}  // namespace deformable_surface::test
