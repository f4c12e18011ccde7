// The times of steps on the clock, and what counts as a jump of the clock.
#include "deformable_surface/ros/convert/step_schedule.h"

#include <gtest/gtest.h>

namespace deformable_surface::node {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000, kStart = 100 * kSecond;

TEST(ClockWatch, HasNoTimeBeforeTheFirst) {
  ClockWatch clock(true);
  EXPECT_EQ(clock.take().now, 0);
  EXPECT_FALSE(clock.observe(kStart, 0));
  const ClockChange change = clock.take();
  EXPECT_EQ(change.now, kStart);
  EXPECT_EQ(change.skipped, 0);
  EXPECT_FALSE(change.jumped_back);
}

TEST(ClockWatch, OfASimulatedClockSkipsForwardJumpsOfMoreThanASecondOnly) {
  ClockWatch clock(true);
  clock.observe(kStart, 0);
  clock.observe(kStart + kSecond, 0);
  EXPECT_EQ(clock.take().skipped, 0);
  clock.observe(kStart + 3 * kSecond, 0);
  clock.observe(kStart + 5 * kSecond, 0);
  EXPECT_EQ(clock.take().skipped, 4 * kSecond);
  EXPECT_EQ(clock.take().skipped, 0);
}

TEST(ClockWatch, OfASimulatedClockTakesEveryStepBackAsAJump) {
  ClockWatch clock(true);
  clock.observe(kStart, 0);
  clock.observe(kStart + 10 * kSecond, 0);
  EXPECT_TRUE(clock.observe(kStart + 10 * kSecond - 1, 0));
  clock.observe(kStart + 10 * kSecond, 0);
  const ClockChange change = clock.take();
  EXPECT_TRUE(change.jumped_back);
  EXPECT_EQ(change.restart, kStart + 10 * kSecond - 1);
  EXPECT_EQ(change.skipped, 0);  // what was skipped before the jump counts no more
  EXPECT_FALSE(clock.take().jumped_back);
}

TEST(ClockWatch, OfTheComputerComparesWithAClockThatNeverJumps) {
  ClockWatch clock(false);
  clock.observe(kStart, 7);
  // A minute without a call is not a jump.
  EXPECT_FALSE(clock.observe(kStart + 60 * kSecond, 7 + 60 * kSecond));
  // A small correction back: no jump.
  EXPECT_FALSE(clock.observe(kStart + 60 * kSecond - kSecond / 10, 8 + 60 * kSecond));
  EXPECT_EQ(clock.take().skipped, 0);
  clock.observe(kStart + 70 * kSecond - kSecond / 10, 8 + 62 * kSecond);
  EXPECT_EQ(clock.take().skipped, 8 * kSecond);
  EXPECT_TRUE(clock.observe(kStart, 8 + 63 * kSecond));
}

TEST(StepSchedule, LaysStepsFromTheStampOfTheCloudOn) {
  StepSchedule schedule(0.01);
  schedule.start(kStart);
  EXPECT_EQ(schedule.begin(0), kStart);
  EXPECT_EQ(schedule.begin(3), kStart + 30'000'000);
  // No drift of rounding after many steps.
  StepSchedule thirds(1.0 / 3.0);
  thirds.start(0);
  EXPECT_EQ(thirds.begin(3'000'000), 1'000'000 * kSecond);
}

TEST(StepSchedule, WhatArrivesWithoutAStampCountsFromTheStepInWhichItArrives) {
  StepSchedule schedule(0.01);
  schedule.start(kStart);
  const auto findStep = [&](std::int64_t arrival) {
    std::uint64_t step = 0;
    while (schedule.begin(step) < stampOfArrival(arrival, 10'000'000)) ++step;
    return step;
  };
  EXPECT_EQ(findStep(kStart + 30'000'000), 3u);
  EXPECT_EQ(findStep(kStart + 35'000'000), 3u);
  EXPECT_EQ(findStep(kStart + 39'999'999), 3u);
  EXPECT_EQ(findStep(kStart + 40'000'000), 4u);
}

TEST(StepSchedule, MovesStepsButNotStampsWhenTimeIsSkipped) {
  StepSchedule schedule(0.01);
  schedule.start(kStart);
  schedule.skip(kSecond);
  EXPECT_EQ(schedule.begin(1), kStart + kSecond + 10'000'000);
  EXPECT_EQ(schedule.stamp(1), kStart + 10'000'000);
  schedule.skipTo(kStart, 1);
  EXPECT_EQ(schedule.begin(1), kStart + kSecond + 10'000'000);
  schedule.skipTo(kStart + 5 * kSecond, 1);
  EXPECT_EQ(schedule.begin(1), kStart + 5 * kSecond);
  schedule.start(kStart);
  EXPECT_EQ(schedule.begin(0), kStart);
}

}  // namespace
}  // namespace deformable_surface::node
