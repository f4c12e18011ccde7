// Every second pixel of an image: which pixels are on this lattice, their links, and which of them the other pixels follow.
#include "deformable_surface/cloud/pixel_lattice.h"

#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace deformable_surface::cloud {
namespace {

// One point per pixel, linked to all neighbours that exist and are not cut off.
struct Image {
  PixelLinks links;
  std::vector<Index> point;
  Points positions;

  Image(
      Index width, Index height, const std::function<bool(Index, Index)>& isSeen = [](Index, Index) { return true; },
      const std::function<bool(Index, Index)>& isCut = [](Index, Index) { return false; }) {
    links = {width, height, std::vector<std::uint8_t>(width * height)};
    point.assign(width * height, -1);
    for (Index p = 0; p < width * height; ++p) {
      if (!isSeen(p % width, p / width)) continue;
      point[p] = static_cast<Index>(positions.size());
      positions.emplace_back(p % width, p / width, 0.0);
    }
    for (Index p = 0; p < width * height; ++p) {
      for (int d = 0; d < 8 && point[p] >= 0; ++d) {
        const Index u = p % width + kPixelSteps[d][0], v = p / width + kPixelSteps[d][1];
        if (u < 0 || u >= width || v < 0 || v >= height || point[v * width + u] < 0) continue;
        if (!isCut(p % width, u)) links.links[p] |= 1 << d;
      }
    }
  }
  PixelLattice halve() const { return takeEverySecond(links, point, positions); }
};

int countLinks(std::uint8_t links) { return __builtin_popcount(links); }

TEST(PixelLattice, OfAFullImageIsEverySecondPixelAndOthersGoWithThoseBesideThem) {
  const Image image(9, 7);
  const PixelLattice half = image.halve();
  ASSERT_EQ(half.links.width, 5);
  ASSERT_EQ(half.links.height, 4);
  EXPECT_EQ(half.points.size(), 20u);
  EXPECT_EQ(countLinks(half.links.links[0]), 3);
  EXPECT_EQ(countLinks(half.links.links[6]), 8);
  for (Index i = 0; i < half.followed.size(); ++i) {
    const Index u = i % 9, v = i / 9, expected = (u % 2 == 1 ? 2 : 1) * (v % 2 == 1 ? 2 : 1);
    EXPECT_EQ(half.followed.count(i), expected) << u << " " << v;
    for (const Index* k = half.followed.begin(i); k != half.followed.end(i); ++k)
      EXPECT_LT((image.positions[half.points[*k]] - image.positions[i]).norm(), 1.5);
  }
}

TEST(PixelLattice, LeadsAcrossNoCut) {
  // Between columns 5 and 6.
  const Image image(
      12, 8, [](Index, Index) { return true; }, [](Index a, Index b) { return std::min(a, b) == 5 && std::max(a, b) == 6; });
  const PixelLattice half = image.halve();
  for (Index p = 0; p < static_cast<Index>(half.place.size()); ++p)
    for (int d = 0; d < 8; ++d) {
      const Index u = p % 6, to = u + kPixelSteps[d][0];
      if (half.links.links[p] >> d & 1) {
        EXPECT_FALSE(std::min(u, to) == 2 && std::max(u, to) == 3);
      }
    }
  for (Index i = 0; i < half.followed.size(); ++i)
    for (const Index* k = half.followed.begin(i); k != half.followed.end(i); ++k)
      EXPECT_EQ(half.points[*k] % 12 <= 5, i % 12 <= 5);
}

TEST(PixelLattice, GoesAroundWhatIsMissing) {
  // The pixel between two of the lattice.
  const Image image(9, 9, [](Index u, Index v) { return u != 3 || v != 4; });
  EXPECT_EQ(countLinks(image.halve().links.links[2 * 5 + 1]), 8);
}

TEST(PixelLattice, HairsGoAsFarAsThreeLinks) {
  // Of row 5, which is not of the lattice, all but the beginning stands alone.
  const Image image(20, 6, [](Index u, Index v) { return v == 5 || u < 4; });
  const PixelLattice half = image.halve();
  const auto countOf = [&](Index u) { return half.followed.count(image.point[5 * 20 + u]); };
  EXPECT_GE(countOf(3), 1);
  EXPECT_EQ(countOf(5), 1);
  EXPECT_EQ(countOf(8), 0);
}

TEST(PixelLattice, TakesAPointThatSeveralPixelsRepeatOnce) {
  Image image(6, 6);
  image.point[2] = image.point[0];
  const PixelLattice half = image.halve();
  EXPECT_EQ(half.points.size(), 8u);
  EXPECT_EQ(half.place[1], -1);
  EXPECT_EQ(half.followed.count(2), 0) << "no pixel shows it";
}

TEST(PixelLattice, IsTheSameForAnyNumberOfThreads) {
  const Image image(200, 150, [](Index u, Index v) { return (u * 7 + v * 13) % 11 != 0; });
  setNumThreads(1);
  const PixelLattice one = image.halve();
  setNumThreads(3);
  const PixelLattice three = image.halve();
  setNumThreads(0);
  EXPECT_EQ(one.links.links, three.links.links);
  EXPECT_EQ(one.points, three.points);
  EXPECT_EQ(one.followed.items, three.followed.items);
}

}  // namespace
}  // namespace deformable_surface::cloud
