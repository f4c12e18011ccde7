// Lists of neighbours over the pixels of an image, against those in space.
#include "deformable_surface/cloud/pixel_links.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace deformable_surface::cloud {
namespace {

// A sheet of pixels, a unit apart in a row and `along` from row to row, with an uneven height that leaves no ties.
struct Image {
  PixelLinks links;
  std::vector<Index> point;
  Points positions;

  Image(Index width, Index height, double along) : links{width, height, {}}, point(width * height) {
    std::iota(point.begin(), point.end(), 0);
    for (Index p = 0; p < width * height; ++p)
      positions.emplace_back(p % width, along * (p / width), 0.2 * std::sin(1.7 * (p % width) + 0.9 * (p / width)));
    cutBetween([](Index, Index) { return false; });
  }

  // Links all neighbouring pixels but those that are cut.
  template <class IsCut>
  void cutBetween(const IsCut& isCut) {
    links.links.assign(point.size(), 0);
    for (Index p = 0; p < static_cast<Index>(point.size()); ++p) {
      for (int d = 0; d < 8; ++d) {
        const Index u = p % links.width + kPixelSteps[d][0], v = p / links.width + kPixelSteps[d][1];
        const bool is_in = u >= 0 && u < links.width && v >= 0 && v < links.height;
        if (is_in && !isCut(p, v * links.width + u)) links.links[p] |= 1 << d;
      }
    }
  }
};

TEST(PixelLinks, GiveTheNearestInSpaceWhereNothingIsCut) {
  for (const double along : {1.0, 2.5}) {
    const Image image(30, 20, along);
    const Lists found = findNeighbors(image.links, image.point, image.positions, 16);
    const Lists nearest = nearestNeighbors(image.positions, 16);
    EXPECT_EQ(found.offsets, nearest.offsets) << along;
    EXPECT_EQ(found.items, nearest.items) << along;
  }
}

TEST(PixelLinks, LeadAcrossNoCut) {
  Image image(20, 20, 1.0);
  // Between columns 9 and 10 of the upper half.
  image.cutBetween([](Index p, Index q) {
    return std::min(p / 20, q / 20) < 10 && std::min(p % 20, q % 20) == 9 && std::max(p % 20, q % 20) == 10;
  });
  const Lists found = findNeighbors(image.links, image.point, image.positions, 16);
  const auto lists = [&](Index i, Index j) { return std::find(found.begin(i), found.end(i), j) != found.end(i); };
  EXPECT_FALSE(lists(2 * 20 + 9, 2 * 20 + 10));
  EXPECT_TRUE(lists(15 * 20 + 9, 15 * 20 + 10));
  EXPECT_EQ(found.count(2 * 20 + 9), 16);
}

TEST(PixelLinks, LeaveOutHolesAndPixelsThatRepeatAPoint) {
  Image image(10, 10, 1.0);
  image.point[33] = -1;
  image.point[55] = 54;
  const Lists found = findNeighbors(image.links, image.point, image.positions, 24);
  EXPECT_EQ(found.count(33), 0) << "no pixel shows it";
  for (Index i = 0; i < found.size(); ++i) {
    std::vector<Index> items(found.begin(i), found.end(i));
    std::sort(items.begin(), items.end());
    EXPECT_EQ(std::adjacent_find(items.begin(), items.end()), items.end()) << i;
    EXPECT_FALSE(std::binary_search(items.begin(), items.end(), 33)) << i;
  }
}

TEST(PixelLinks, AreAddedBelowTheLeastGap) {
  Image image(10, 10, 1.0);
  image.cutBetween([](Index, Index) { return true; });
  EXPECT_EQ(findNeighbors(image.links, image.point, image.positions, 8).items.size(), 0u);
  EXPECT_EQ(findNeighbors(image.links, image.point, image.positions, 8, 5.0).count(55), 8);
}

TEST(PixelLinks, AreAddedOverMissingRowsBelowTheLeastGap) {
  Image image(10, 10, 1.0);
  for (Index u = 0; u < 10; ++u) image.point[5 * 10 + u] = -1;
  image.cutBetween([](Index p, Index q) { return p / 10 == 5 || q / 10 == 5; });
  const auto leadsOver = [&](double min_gap) {
    const Lists found = findNeighbors(image.links, image.point, image.positions, 20, min_gap);
    return std::any_of(found.begin(45), found.end(45), [](Index j) { return j / 10 == 6; });
  };
  EXPECT_FALSE(leadsOver(0.0));
  EXPECT_FALSE(leadsOver(1.5));
  EXPECT_TRUE(leadsOver(2.3));
}

TEST(PixelLinks, GiveTheSameListsForAnyNumberOfThreads) {
  const Image image(80, 60, 1.5);
  setNumThreads(1);
  const Lists one = findNeighbors(image.links, image.point, image.positions, 20);
  setNumThreads(3);
  const Lists three = findNeighbors(image.links, image.point, image.positions, 20);
  setNumThreads(0);
  EXPECT_EQ(one.offsets, three.offsets);
  EXPECT_EQ(one.items, three.items);
}

TEST(PixelLinks, MustFitTheImage) {
  const Image image(10, 10, 1.0);
  EXPECT_THROW(findNeighbors(image.links, std::vector<Index>(99), image.positions, 8), InputError);
}

}  // namespace
}  // namespace deformable_surface::cloud
