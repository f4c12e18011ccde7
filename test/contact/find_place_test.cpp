#include "../../src/contact/find_place.h"

#include "deformable_surface/base/types.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

namespace deformable_surface::contact {
namespace {

TEST(FindPlace, DoesNotDependOnTheGuess) {
  std::vector<int> items;
  for (Index num = 0; num <= 40; ++num) {
    for (int key = -1; key <= 2 * num + 1; ++key) {
      const Index expected = std::lower_bound(items.begin(), items.end(), key) - items.begin();
      for (Index guess = 0; guess <= num + 3; ++guess)
        EXPECT_EQ(findPlace(items, key, guess, std::less<int>()), expected) << num << ' ' << key << ' ' << guess;
    }
    items.push_back(2 * num);
  }
}

TEST(FindPlace, ComparesLittleNearTheGuess) {
  std::vector<int> items(100000);
  for (std::size_t i = 0; i < items.size(); ++i) items[i] = static_cast<int>(i);
  int num_compared = 0;
  const auto isBefore = [&](int item, int key) {
    ++num_compared;
    return item < key;
  };
  for (const auto& [off, most] : {std::pair<Index, int>{0, 2}, {1, 4}, {-1, 4}, {10, 10}, {-10, 10}}) {
    num_compared = 0;
    EXPECT_EQ(findPlace(items, 50000, 50000 + off, isBefore), 50000);
    EXPECT_LE(num_compared, most) << off;
  }
}

}  // namespace
}  // namespace deformable_surface::contact
