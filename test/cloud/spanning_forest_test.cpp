#include "../../src/cloud/spanning_forest.h"

#include "deformable_surface/base/random.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <tuple>

namespace deformable_surface::cloud {
namespace {

struct Link {
  double weight;
  Index i, j;
  bool operator<(const Link& other) const { return std::tie(weight, i, j) < std::tie(other.weight, other.i, other.j); }
  bool operator==(const Link& other) const { return std::tie(weight, i, j) == std::tie(other.weight, other.i, other.j); }
};

constexpr Index kPoints = 5000, kLinks = 8;  // several portions, blocks and samples

// Two parts without a link between them; num_weights small: many links weigh the same.
std::vector<std::vector<Link>> makeLinks(std::uint32_t num_weights) {
  std::vector<std::vector<Link>> links(kPoints);
  std::uint32_t random = 1;
  for (Index i = 0; i < kPoints; ++i) {
    for (Index k = 0; k < kLinks; ++k) {
      nextRandom(random);
      const Index half = kPoints / 2, j = static_cast<Index>((random >> 8) % half) + (i < half ? 0 : half);
      if (i == j) continue;
      const double weight = static_cast<double>((random >> 4) % num_weights);
      links[i].push_back({weight, std::min(i, j), std::max(i, j)});
      links[j].push_back(links[i].back());
    }
  }
  return links;
}

class Sets {
 public:
  Sets() : parent_(kPoints) { std::iota(parent_.begin(), parent_.end(), 0); }
  Index find(Index i) const {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  bool join(const Link& link) {
    const Index a = find(link.i), b = find(link.j);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<Index> parent_;
};

TEST(SpanningForest, IsThatOfSortingAllLinks) {
  for (const std::uint32_t num_weights : {1000003u, 3u}) {
    const std::vector<std::vector<Link>> links = makeLinks(num_weights);
    std::vector<Link> all;
    for (const std::vector<Link>& own : links) all.insert(all.end(), own.begin(), own.end());
    std::sort(all.begin(), all.end());
    std::vector<Link> expected;
    Sets sets;
    for (const Link& link : all)
      if (sets.join(link)) expected.push_back(link);
    EXPECT_EQ(expected.size(), kPoints - 2u);

    for (const int threads : {1, 2}) {
      setNumThreads(threads);
      std::vector<Link> forest;
      Sets found;
      visitSpanningForest<Link>(
          kPoints, [&](Index i, const auto& visit) { std::for_each(links[i].begin(), links[i].end(), visit); },
          [&](Index i) { return found.find(i); },
          [&](const Link& link) {
            if (found.join(link)) forest.push_back(link);
          });
      EXPECT_EQ(forest, expected) << num_weights << " weights, " << threads << " threads";
    }
  }
  setNumThreads(0);
}

}  // namespace
}  // namespace deformable_surface::cloud
