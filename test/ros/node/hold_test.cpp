// Only the call that holds the surface may replace it or let it go.
#include "../../../src/ros/node/hold.h"

#include <gtest/gtest.h>

namespace deformable_surface::node {
namespace {

TEST(Hold, EndsOnce) {
  Hold hold;
  EXPECT_FALSE(hold.isActive());
  const Hold::Id id = hold.begin();
  EXPECT_TRUE(hold.isActive());
  EXPECT_TRUE(hold.end(id));
  EXPECT_FALSE(hold.isActive());
  EXPECT_FALSE(hold.end(id));
}

// As where the surface is reset while it grows, and grown again before the first growth ends.
TEST(Hold, OneThatWasCancelledDoesNotEndTheNext) {
  Hold hold;
  const Hold::Id first = hold.begin();
  hold.cancel();
  EXPECT_FALSE(hold.isActive());
  const Hold::Id second = hold.begin();
  EXPECT_FALSE(hold.end(first));
  EXPECT_TRUE(hold.isActive());
  EXPECT_TRUE(hold.end(second));
}

}  // namespace
}  // namespace deformable_surface::node
