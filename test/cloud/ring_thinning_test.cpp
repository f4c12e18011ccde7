// Thinning point by point, apart from how simplify() divides a cloud.
#include "../../src/cloud/ring_thinning.h"

#include "cloud/test_surfaces.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace deformable_surface::cloud {
namespace {

constexpr Index kNeighbors = 12;

// Two sheets side by side, 3 units apart, as two parts.
struct TwoSheets {
  explicit TwoSheets(int side, double jitter = 0.0) {
    const TestSurface sheet = makeSheet(side, jitter);
    surface = sheet;
    surface.append(sheet, Vec3(3.0, 0.0, 0.0));
    part.assign(surface.positions.size(), 0);
    std::fill(part.begin() + sheet.size(), part.end(), 1);
    stays.assign(surface.positions.size(), 0);
    left_out.assign(2, 0);
  }

  Simplification thin(Index min_points) const {
    return thinByRings({surface.positions, surface.normals, wanted, kNeighbors,
                        nearestNeighbors(surface.positions, 2 * kNeighbors), part, left_out, false},
                       min_points, stays);
  }
  Index countRemoved(const Simplification& thinned, Index of_part) const {
    return static_cast<Index>(
        std::count_if(thinned.removed.begin(), thinned.removed.end(), [&](Index i) { return part[i] == of_part; }));
  }

  TestSurface surface;
  std::vector<double> wanted;
  std::vector<Index> part;
  std::vector<char> stays, left_out;
};

TEST(RingThinning, EndsAtTheNumberAskedForWithKeysThatNeverFall) {
  const TwoSheets sheets(20, 0.2);
  const Simplification thinned = sheets.thin(100);
  EXPECT_EQ(thinned.num_points, 800);
  EXPECT_EQ(thinned.removed.size(), 700u);
  EXPECT_TRUE(std::is_sorted(thinned.diameter.begin(), thinned.diameter.end()));
  EXPECT_NEAR(sheets.countRemoved(thinned, 0), 350, 20) << "equal parts are thinned alike";
}

TEST(RingThinning, WhatStaysIsNeverRemoved) {
  TwoSheets sheets(10);
  for (std::size_t i = 0; i < sheets.stays.size(); i += 2) sheets.stays[i] = 1;
  const Simplification thinned = sheets.thin(0);
  EXPECT_EQ(thinned.removed.size(), 100u);
  for (const Index i : thinned.removed) EXPECT_EQ(i % 2, 1);
}

TEST(RingThinning, EveryPartKeepsThreePointsUnlessItIsLeftOutWhichGoesFirst) {
  TwoSheets sheets(8);
  EXPECT_EQ(sheets.thin(0).removed.size(), 2u * (64 - kMinPartPoints));
  sheets.left_out[1] = 1;
  const Simplification thinned = sheets.thin(0);
  EXPECT_EQ(sheets.countRemoved(thinned, 1), 64);
  EXPECT_EQ(sheets.countRemoved(thinned, 0), 64 - kMinPartPoints);
  for (std::size_t r = 0; r < 64; ++r) EXPECT_EQ(sheets.part[thinned.removed[r]], 1) << r;
}

TEST(RingThinning, AWantedSpacingIsKeptByTheShareOfPoints) {
  TwoSheets sheets(24, 0.2);
  sheets.wanted.assign(sheets.surface.positions.size(), 1.0);
  for (std::size_t i = 0; i < sheets.wanted.size(); ++i)
    if (sheets.part[i] == 1) sheets.wanted[i] = 2.0;
  const Simplification thinned = sheets.thin(300);
  const double left = 576 - sheets.countRemoved(thinned, 0), left_coarse = 576 - sheets.countRemoved(thinned, 1);
  EXPECT_NEAR(left / left_coarse, 4.0, 1.0) << "a quarter of the points at twice the spacing, but for the rims";
}

// With more than one thread, points are evaluated ahead of their turn.
TEST(RingThinning, IsTheSameForAnyNumberOfThreads) {
  const TwoSheets sheets(100, 0.3);
  setNumThreads(1);
  const Simplification one = sheets.thin(200);
  setNumThreads(3);
  const Simplification three = sheets.thin(200);
  setNumThreads(0);
  EXPECT_EQ(one.removed, three.removed);
  EXPECT_EQ(one.diameter, three.diameter);
}

}  // namespace
}  // namespace deformable_surface::cloud
