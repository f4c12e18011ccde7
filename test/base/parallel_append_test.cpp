#include "deformable_surface/base/parallel_append.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace deformable_surface {
namespace {

class ParallelAppend : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { setNumThreads(GetParam()); }
  void TearDown() override { setNumThreads(0); }
};

// Twice the numbers below n that three does not divide.
std::vector<Index> append(Index n, std::vector<Index> list, AppendedParts<Index>& parts) {
  parallelAppend(n, 10, list, parts, [](Index begin, Index end, std::vector<Index>& part) {
    for (Index i = begin; i < end; ++i)
      if (i % 3 != 0) part.push_back(2 * i);
  });
  return list;
}

TEST_P(ParallelAppend, ItemsFollowThoseBeforeInTheOrderOfTheirIndices) {
  AppendedParts<Index> parts;
  for (const Index n : {1000, 101, 10, 7, 1, 0, 20}) {  // what a longer loop has left is not appended again
    std::vector<Index> expected{-1};
    for (Index i = 0; i < n; ++i)
      if (i % 3 != 0) expected.push_back(2 * i);
    EXPECT_EQ(append(n, {-1}, parts), expected) << n;
  }
}

TEST_P(ParallelAppend, NothingIsAllocatedAgain) {
  AppendedParts<Index> parts;
  append(1000, {}, parts);
  std::vector<const Index*> before, after;
  for (const std::vector<Index>& part : parts) before.push_back(part.data());
  append(1000, {}, parts);
  for (const std::vector<Index>& part : parts) after.push_back(part.data());
  EXPECT_EQ(before, after);
}

TEST_P(ParallelAppend, ASingleBlockRunsInTheCallingThread) {
  std::vector<std::thread::id> threads;
  AppendedParts<std::thread::id> parts;
  parallelAppend(100, 100, threads, parts,
                 [](Index, Index, std::vector<std::thread::id>& list) { list.push_back(std::this_thread::get_id()); });
  EXPECT_EQ(threads, std::vector<std::thread::id>{std::this_thread::get_id()});
  EXPECT_TRUE(parts.empty());
}

INSTANTIATE_TEST_SUITE_P(Threads, ParallelAppend, testing::Values(1, 2, 5));

}  // namespace
}  // namespace deformable_surface
