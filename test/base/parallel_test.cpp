#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace deformable_surface {
namespace {

class Parallel : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { setNumThreads(GetParam()); }
  void TearDown() override { setNumThreads(0); }
};

TEST_P(Parallel, LoopsCoverEveryIndexOnce) {
  for (Index n : {0, 1, 99, 100, 101, 1000, 12345}) {
    std::vector<int> seen(n, 0);
    parallelFor(n, 100, [&](Index begin, Index end) {
      EXPECT_EQ(begin % 100, 0);
      for (Index i = begin; i < end; ++i) ++seen[i];
    });
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), n);
  }
}

TEST_P(Parallel, SumsDoNotDependOnTheNumberOfThreads) {
  const auto sum = [] {
    return parallelSum(100000, 64, [](Index begin, Index end) {
      double s = 0.0;
      for (Index i = begin; i < end; ++i) s += 1.0 / (1.0 + i);
      return s;
    });
  };
  const double here = sum();
  EXPECT_NEAR(here, std::log(1e5) + 0.5772156649 + 0.5e-5, 1e-9);  // the harmonic number: no block is missing
  setNumThreads(1);
  EXPECT_EQ(here, sum());
}

TEST_P(Parallel, NestedLoopsRun) {
  std::atomic<int> count{0};
  parallelFor(50, 1, [&](Index, Index) { parallelFor(50, 1, [&](Index, Index) { ++count; }); });
  EXPECT_EQ(count, 2500);
}

TEST_P(Parallel, TheExceptionOfTheLowestBlockIsThrownAndLaterLoopsRun) {
  for (int repeat = 0; repeat < 20; ++repeat) {
    try {
      parallelFor(100, 1, [](Index begin, Index) {
        if (begin >= 10) throw std::runtime_error(std::to_string(begin));
      });
      FAIL();
    } catch (const std::runtime_error& e) {
      EXPECT_STREQ(e.what(), "10");
    }
  }
}

TEST_P(Parallel, SeveralCallersAtOnceDoNotMixTheirWork) {
  std::atomic<long> total{0};
  std::vector<std::thread> callers;
  for (int c = 0; c < 4; ++c)
    callers.emplace_back([&] {
      for (int repeat = 0; repeat < 50; ++repeat) parallelFor(1000, 10, [&](Index begin, Index end) { total += end - begin; });
    });
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(total, 4L * 50 * 1000);
}

// Workers look for the next loop for a while, then sleep. Each of these loops comes while they look, fall asleep or sleep.
TEST_P(Parallel, LoopsMayComeAtAnyTime) {
  std::vector<int> seen(64);
  for (int repeat = 0; repeat < 3000; ++repeat) {
    std::fill(seen.begin(), seen.end(), 0);
    parallelFor(64, 1 + repeat % 16, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) ++seen[i];
    });
    ASSERT_EQ(std::count(seen.begin(), seen.end(), 1), 64) << repeat;
    const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(repeat % 150);
    while (std::chrono::steady_clock::now() < end) {}
  }
}

// Number of threads that take part in a loop of many blocks.
std::set<std::thread::id> findThreads() {
  std::mutex mutex;
  std::set<std::thread::id> ids;
  parallelFor(200, 1, [&](Index, Index) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      ids.insert(std::this_thread::get_id());
    }
    std::this_thread::sleep_for(std::chrono::microseconds(100));  // lets other threads run
  });
  return ids;
}

TEST(NumThreads, IsThatOfTheThreadThatBeginsTheLoop) {
  setNumThreads(3);
  std::thread([] {
    setNumThreads(1);
    EXPECT_EQ(numThreads(), 1);
    EXPECT_EQ(findThreads(), std::set<std::thread::id>{std::this_thread::get_id()});
  }).join();
  EXPECT_EQ(numThreads(), 3);
  EXPECT_EQ(findThreads().count(std::this_thread::get_id()), 1u);
  setNumThreads(0);
}

TEST(NumThreads, HoldsAlsoAfterALoopWithMore) {
  setNumThreads(8);
  findThreads();
  setNumThreads(2);
  EXPECT_LE(findThreads().size(), 2u);
  setNumThreads(0);
}

INSTANTIATE_TEST_SUITE_P(Threads, Parallel, testing::Values(1, 2, 3, 8));

}  // namespace
}  // namespace deformable_surface
