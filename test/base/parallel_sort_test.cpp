#include "deformable_surface/base/parallel_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

namespace deformable_surface {
namespace {

std::vector<std::uint32_t> makeValues(std::size_t n) {
  std::vector<std::uint32_t> values(n);
  for (std::size_t i = 0; i < n; ++i) values[i] = static_cast<std::uint32_t>(i * 2654435769u) % 100003;
  return values;
}

TEST(ParallelSort, SortsAnyNumberOfValuesAsOneThreadDoes) {
  for (const std::size_t n : {0, 1, 2, 1000, (1 << 14) - 1, (1 << 14) + 1, 3 << 14, 100000}) {
    std::vector<std::uint32_t> sorted = makeValues(n);
    std::sort(sorted.begin(), sorted.end());
    for (const int threads : {1, 2, 3}) {
      setNumThreads(threads);
      std::vector<std::uint32_t> values = makeValues(n);
      parallelSort(values);
      EXPECT_EQ(values, sorted) << n << " values, " << threads << " threads";
    }
  }
  setNumThreads(0);
}

}  // namespace
}  // namespace deformable_surface
