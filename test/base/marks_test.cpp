#include "deformable_surface/base/marks.h"

#include <gtest/gtest.h>

namespace deformable_surface {
namespace {

TEST(Marks, EachThingIsTakenOnceUntilTheNextBeginning) {
  Marks marks;
  for (const Index n : {5, 3, 8}) {
    marks.begin(n);
    for (Index i = 0; i < n; ++i) {
      EXPECT_TRUE(marks.take(i)) << i << " of " << n;
      EXPECT_FALSE(marks.take(i)) << i << " of " << n;
    }
  }
}

}  // namespace
}  // namespace deformable_surface
