// Lists by point, and directions for points without one.
#include "deformable_surface/model/mass_spring/incidence.h"

#include <gtest/gtest.h>

namespace deformable_surface::model {
namespace {

TEST(Incidence, KeepsTheOrderOfTheItemsOfEachPoint) {
  const Lists lists = groupByPoint(4, {{2, 7}, {0, 5}, {2, 3}, {3, 1}, {0, 9}});
  EXPECT_EQ(lists.offsets, (std::vector<Index>{0, 2, 2, 4, 5}));
  EXPECT_EQ(lists.items, (std::vector<Index>{5, 9, 7, 3, 1}));
  EXPECT_TRUE(groupByPoint(2, {}).items.empty());
}

TEST(Incidence, DirectionsAreOfUnitLengthAlwaysTheSameAndFewAlike) {
  for (Index i = 0; i < 20; ++i)
    for (Index j = 0; j < 20; ++j) {
      const Vec3 direction = fixedDirection(i, j);
      EXPECT_NEAR(direction.norm(), 1.0, 1e-12);
      EXPECT_EQ(direction, fixedDirection(i, j));
    }
  EXPECT_NE(fixedDirection(0, 1), fixedDirection(0, 2));
}

}  // namespace
}  // namespace deformable_surface::model
