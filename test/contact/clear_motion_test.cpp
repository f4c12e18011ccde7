// Whether points come as predicted.
#include "deformable_surface/contact/clear_motion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::contact {
namespace {

// Points in a row, the last of which moves fastest, along y.
struct Row {
  Points positions, velocities;
  ClearMotion motion;

  explicit Row(int size = 11) {
    for (int i = 0; i < size; ++i) {
      const double place = static_cast<double>(i) / (size - 1);
      positions.emplace_back(place, 0.0, 0.0);
      velocities.emplace_back(0.0, place, 0.0);
    }
    motion.predict(positions, velocities, 2.0);
  }
  Points at(double time) const {
    Points there = positions;
    for (std::size_t i = 0; i < there.size(); ++i) there[i] += time * velocities[i];
    return there;
  }
};

TEST(ClearMotion, KnowsWhatIsPredicted) {
  const Row row;
  EXPECT_EQ(row.motion.leader, 10);
  EXPECT_DOUBLE_EQ(row.motion.shareAt(row.at(0.5)[10]), 0.25);
  EXPECT_EQ(row.motion.shareAt(row.at(3.0)[10]), 1.0);
  for (const double time : {0.0, 0.7, 2.0}) EXPECT_TRUE(row.motion.isNear(row.at(time), 1e-12)) << time;
  // Beyond its end the motion is not predicted: points differ by up to 0.5 m there.
  EXPECT_FALSE(row.motion.isNear(row.at(2.5), 0.2));
  EXPECT_TRUE(row.motion.isNear(row.at(2.5), 0.26));
}

TEST(ClearMotion, EachPointCounts) {
  for (const int size : {11, 3001, 20001}) {  // in one task, in a few, in as many as there are
    const Row row(size);
    for (int i = 0; i < size - 1; i += 1 + size / 20)
      for (int axis = 0; axis < 3; ++axis) {
        Points there = row.at(1.0);
        there[i][axis] += 0.02;
        EXPECT_FALSE(row.motion.isNear(there, 0.009)) << i;
        EXPECT_TRUE(row.motion.isNear(there, 0.011)) << i;
        there[i][axis] = std::nan("");
        EXPECT_FALSE(row.motion.isNear(there, 1.0)) << i;
        there[i][axis] = INFINITY;
        EXPECT_FALSE(row.motion.isNear(there, 1.0)) << i;
      }
  }
}

TEST(ClearMotion, ACommonDisplacementDoesNotCount) {
  const Row row;
  Points there = row.at(1.0);
  for (Vec3& p : there) p += Vec3(5.0, 0.0, -3.0);
  EXPECT_TRUE(row.motion.isNear(there, 1e-12));
}

TEST(ClearMotion, LooksAtTheEndOfAStep) {
  const Row row;
  EXPECT_TRUE(row.motion.isNear(row.at(0.5), row.velocities, 1.0, 1e-12));
  EXPECT_FALSE(row.motion.isNear(row.at(0.5), row.velocities, 2.0, 0.2));
  Points sudden = row.velocities;
  sudden[3].z() = 1.0;
  EXPECT_TRUE(row.motion.isNear(row.at(0.5), sudden, 0.0, 1e-12));
  EXPECT_FALSE(row.motion.isNear(row.at(0.5), sudden, 0.1, 0.04));
}

}  // namespace
}  // namespace deformable_surface::contact
