#include "deformable_surface/base/disjoint_sets.h"

#include <gtest/gtest.h>

#include <random>

namespace deformable_surface {
namespace {

TEST(DisjointSets, TheRootIsTheSmallestIndexAndSetsAreNumberedInItsOrder) {
  std::vector<Index> parents;
  makeSingleSets(6, parents);
  EXPECT_TRUE(joinSets(parents, 5, 3));
  EXPECT_TRUE(joinSets(parents, 4, 1));
  EXPECT_TRUE(joinSets(parents, 3, 2));
  EXPECT_FALSE(joinSets(parents, 5, 2));
  EXPECT_EQ(findRoot(parents, 5), 2);
  EXPECT_EQ(findRoot(parents, 4), 1);
  EXPECT_EQ(findRoot(parents, 0), 0);
  Index num_sets = 0;
  EXPECT_EQ(labelSets(parents, num_sets), (std::vector<Index>{0, 1, 2, 2, 1, 2}));
  EXPECT_EQ(num_sets, 3);
  makeSingleSets(3, parents);
  EXPECT_EQ(labelSets(parents, num_sets), (std::vector<Index>{0, 1, 2}));
}

// Against labels that are overwritten one by one.
TEST(DisjointSets, TheOrderOfPairsDoesNotMatter) {
  std::mt19937 engine(3);
  for (const Index n : {1, 10, 300}) {
    std::uniform_int_distribution<Index> draw(0, n - 1);
    std::vector<Index> parents, lowest;
    makeSingleSets(n, parents);
    makeSingleSets(n, lowest);
    for (Index k = 0; k < n; ++k) {
      const Index i = draw(engine), j = draw(engine);
      const Index a = std::min(lowest[i], lowest[j]), b = std::max(lowest[i], lowest[j]);
      EXPECT_EQ(joinSets(parents, i, j), a != b);
      std::replace(lowest.begin(), lowest.end(), b, a);
    }
    for (Index i = 0; i < n; ++i) EXPECT_EQ(findRoot(parents, i), lowest[i]);
  }
}

}  // namespace
}  // namespace deformable_surface
