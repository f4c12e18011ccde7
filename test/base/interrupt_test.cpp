#include "deformable_surface/base/interrupt.h"

#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace deformable_surface {
namespace {

constexpr Index kMany = 1000;

TEST(Interrupt, OutsideOfAScopeNothingEnds) {
  EXPECT_EQ(currentInterrupt(), nullptr);
  EXPECT_NO_THROW(endIfInterrupted());
}

TEST(Interrupt, EndsALoopBetweenTwoBlocksOnAnyNumberOfThreads) {
  for (const int threads : {1, 2, 4}) {
    setNumThreads(threads);
    std::atomic<bool> flag{false};
    std::atomic<Index> done{0};
    const InterruptScope scope(flag);
    EXPECT_THROW(parallelFor(kMany, 1,
                             [&](Index, Index) {
                               flag = true;
                               ++done;
                             }),
                 Interrupted);
    EXPECT_LE(done, threads);  // blocks that have begun are finished
    EXPECT_GE(done, 1);
  }
  setNumThreads(0);
}

TEST(Interrupt, EndsTheNextLoopAndItsSums) {
  std::atomic<bool> flag{true};
  const InterruptScope scope(flag);
  EXPECT_THROW(parallelFor(kMany, 1, [](Index, Index) {}), Interrupted);
  EXPECT_THROW(parallelSum(kMany, 1, [](Index, Index) { return 1.0; }), Interrupted);
  EXPECT_THROW(endIfInterrupted(), Interrupted);
}

TEST(Interrupt, LeavesLoopsWholeWhileTheFlagIsFalse) {
  std::atomic<bool> flag{false};
  const InterruptScope scope(flag);
  EXPECT_EQ(parallelSum(kMany, 1, [](Index begin, Index) { return static_cast<double>(begin); }), 0.5 * kMany * (kMany - 1));
}

TEST(Interrupt, IsAMatterOfTheThreadAndOfTheInnermostScope) {
  std::atomic<bool> outer_flag{false}, inner_flag{true};
  const InterruptScope outer(outer_flag);
  {
    const InterruptScope inner(inner_flag);
    EXPECT_THROW(endIfInterrupted(), Interrupted);
    std::thread([] { EXPECT_NO_THROW(endIfInterrupted()); }).join();
  }
  EXPECT_NO_THROW(endIfInterrupted());
  EXPECT_EQ(currentInterrupt(), &outer_flag);
}

// The pool works for other threads afterwards.
TEST(Interrupt, LeavesThePoolReadyForTheNextLoop) {
  std::atomic<bool> flag{true};
  try {
    const InterruptScope scope(flag);
    parallelFor(kMany, 1, [](Index, Index) {});
    FAIL() << "was not interrupted";
  } catch (const Interrupted&) {}
  std::atomic<Index> done{0};
  parallelFor(kMany, 1, [&](Index, Index) { ++done; });
  EXPECT_EQ(done, kMany);
}

}  // namespace
}  // namespace deformable_surface
