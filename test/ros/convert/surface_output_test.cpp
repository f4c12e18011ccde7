// Statistics as a message.
#include "deformable_surface/ros/convert/surface_output.h"

#include <gtest/gtest.h>

namespace deformable_surface::node {
namespace {

TEST(EncodeStatistics, FillsOldNamesAsTheNewOnes) {
  simulation::Statistics statistics;
  statistics.links = 7;
  statistics.error_bounded = true;
  statistics.error_stiffness = 0.5;
  statistics.tracking_residual = 0.25;
  statistics.tracked_points = 3;
  Statistics message;
  encodeStatistics(statistics, {}, message);
  EXPECT_EQ(message.links, 7u);
  EXPECT_TRUE(message.error_bounded);
  EXPECT_EQ(message.springs, 7u);
  EXPECT_EQ(message.error_stiffness, 0.5);
  EXPECT_EQ(message.error_softening, 0.5);
  EXPECT_EQ(message.tracking_residual, 0.25);
  EXPECT_EQ(message.track_residual, 0.25);
  EXPECT_EQ(message.tracked_points, 3u);
  EXPECT_EQ(message.track_points, 3u);
}

}  // namespace
}  // namespace deformable_surface::node
