// The resampler bounds the gaps of stretched sheets, inserts points on the surface, and never changes the meaning of an index.
#include "deformable_surface/transfer/resample.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::transfer {
namespace {

constexpr Index kSide = 21;

// Rings of a square grid with both diagonals, as the star of a grid has them.
cloud::Rings makeGridRings(Index rows, Index columns) {
  cloud::Rings rings;
  for (Index i = 0; i < rows; ++i) {
    for (Index j = 0; j < columns; ++j) {
      for (Index di = -1; di <= 1; ++di) {
        for (Index dj = -1; dj <= 1; ++dj) {
          const bool inside = i + di >= 0 && i + di < rows && j + dj >= 0 && j + dj < columns;
          if (inside && (di != 0 || dj != 0)) rings.ring.items.push_back((i + di) * columns + j + dj);
        }
      }
      rings.ring.offsets.push_back(static_cast<Index>(rings.ring.items.size()));
    }
  }
  return rings;
}

Points makeSheet() {
  Points sheet;
  for (Index i = 0; i < kSide; ++i) {
    for (Index j = 0; j < kSide; ++j) sheet.emplace_back(i / (kSide - 1.0), j / (kSide - 1.0), 0.0);
  }
  return sheet;
}

// Positions at rest of the input's and the inserted points together.
Points collectRest(const Points& dense, const Resampler& resampler) {
  Points all = dense;
  all.insert(all.end(), resampler.insertedRest().begin(), resampler.insertedRest().end());
  return all;
}

template <class Map>
Points moved(const Points& points, const Map& map) {
  Points result;
  for (const Vec3& p : points) result.push_back(map(p));
  return result;
}

// Calls update until nothing is inserted any more; the number of calls that inserted.
template <class Map>
int updateUntilDone(const Points& dense, Resampler& resampler, const Map& map) {
  int calls = 0;
  while (calls < 50 && resampler.update(moved(collectRest(dense, resampler), map)) > 0) ++calls;
  return calls;
}

// The largest distance of any place on the stretched sheet to its nearest point.
template <class Map>
double findLargestGap(const Points& now, const Map& map) {
  double gap = 0.0;
  for (int i = 0; i <= 83; ++i) {
    for (int j = 0; j <= 83; ++j) {
      const Vec3 place = map(Vec3(i / 83.0, j / 83.0, 0.0));
      double nearest = std::numeric_limits<double>::infinity();
      for (const Vec3& p : now) nearest = std::min(nearest, (p - place).norm());
      gap = std::max(gap, nearest);
    }
  }
  return gap;
}

Vec3 stretchThreefold(const Vec3& p) { return {3.0 * p.x(), p.y(), p.z()}; }

TEST(Resampler, KeepsGapsBoundedOnASheetStretchedThreefold) {
  const Points sheet = makeSheet();
  const double spacing = 1.0 / (kSide - 1);
  const auto both_ways = [](const Vec3& p) { return Vec3(3.0 * p); };
  for (Vec3 (*map)(const Vec3&) : {+both_ways, stretchThreefold}) {
    Resampler resampler(sheet, Points(sheet.size(), Vec3::UnitZ()), makeGridRings(kSide, kSide), 1.5, 100000);
    EXPECT_LE(updateUntilDone(sheet, resampler, map), 4);
    const Points now = moved(collectRest(sheet, resampler), map);
    EXPECT_GT(findLargestGap(moved(sheet, map), map), 1.4 * spacing);
    // Links end at 1.5 mean links of about 1.25 spacings; the middle of a triangle is 0.58 sides from its corners.
    EXPECT_LT(findLargestGap(now, map), 1.5 * 1.25 * 0.58 * spacing);
    // Not many more than the area requires, and none on top of another.
    EXPECT_LT(resampler.insertedRest().size(), 9 * sheet.size());
    const Points rest = collectRest(sheet, resampler);
    double closest = 1.0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) closest = std::min(closest, (rest[i] - rest[j]).norm());
    }
    EXPECT_GT(closest, 0.1 * spacing);
  }
}

TEST(Resampler, InsertsNothingAtRestUnderRigidMotionOrSmallStretch) {
  const Points sheet = makeSheet();
  Resampler resampler(sheet, Points(sheet.size(), Vec3::UnitZ()), makeGridRings(kSide, kSide), 1.5, 100000);
  EXPECT_EQ(0, resampler.update(sheet));
  EXPECT_EQ(0, resampler.update(moved(sheet, [](const Vec3& p) { return Vec3(7.0 - p.y(), p.x(), p.z() + 5.0); })));
  EXPECT_EQ(0, resampler.update(moved(sheet, [](const Vec3& p) { return Vec3(1.45 * p); })));
  EXPECT_TRUE(resampler.insertedRest().empty());
}

TEST(Resampler, NeverChangesWhatAnIndexMeans) {
  const Points sheet = makeSheet();
  Resampler resampler(sheet, Points(sheet.size(), Vec3::UnitZ()), makeGridRings(kSide, kSide), 1.5, 100000);
  updateUntilDone(sheet, resampler, [](const Vec3& p) { return Vec3(2.0 * p.x(), p.y(), p.z()); });
  const Points before = resampler.insertedRest();
  const auto parents = resampler.parents();
  ASSERT_FALSE(before.empty());
  // Released: no point is removed. Stretched further: more points are appended.
  EXPECT_EQ(0, resampler.update(collectRest(sheet, resampler)));
  updateUntilDone(sheet, resampler, [](const Vec3& p) { return Vec3(6.0 * p.x(), p.y(), p.z()); });
  ASSERT_GT(resampler.insertedRest().size(), before.size());
  ASSERT_EQ(resampler.insertedRest().size(), resampler.parents().size());
  ASSERT_EQ(resampler.insertedRest().size(), resampler.insertedNormals().size());
  EXPECT_TRUE(std::equal(before.begin(), before.end(), resampler.insertedRest().begin()));
  EXPECT_TRUE(std::equal(parents.begin(), parents.end(), resampler.parents().begin()));
  // Every point lies between its parents, which came before it.
  const Points rest = collectRest(sheet, resampler);
  for (std::size_t p = 0; p < resampler.parents().size(); ++p) {
    const auto [a, b] = resampler.parents()[p];
    ASSERT_LT(std::max(a, b), static_cast<Index>(sheet.size() + p));
    EXPECT_LT((rest[sheet.size() + p] - 0.5 * (rest[a] + rest[b])).norm(), 1e-12);
    EXPECT_LT((resampler.insertedNormals()[p] - Vec3::UnitZ()).norm(), 1e-12);
  }
}

TEST(Resampler, InsertsOnTheCurvedSurface) {
  // A part of a unit cylinder; the middles of links lie up to 5e-3 inside.
  const Index rows = 15, columns = 12;
  Points dense, normals;
  for (Index i = 0; i < rows; ++i) {
    for (Index j = 0; j < columns; ++j) {
      const double angle = 0.2 * i;
      normals.emplace_back(std::cos(angle), std::sin(angle), 0.0);
      dense.push_back(normals.back() + Vec3(0.0, 0.0, 0.2 * j));
    }
  }
  Resampler resampler(dense, normals, makeGridRings(rows, columns), 1.5, 100000);
  resampler.update(moved(dense, [](const Vec3& p) { return Vec3(2.0 * p); }));
  ASSERT_GT(resampler.insertedRest().size(), 100u);
  double largest = 0.0;
  for (std::size_t p = 0; p < resampler.insertedRest().size(); ++p) {
    const Vec3 radial(resampler.insertedRest()[p].x(), resampler.insertedRest()[p].y(), 0.0);
    largest = std::max(largest, std::abs(radial.norm() - 1.0));
    EXPECT_LT((resampler.insertedNormals()[p] - radial.normalized()).norm(), 0.02);
  }
  EXPECT_LT(largest, 5e-4);
}

TEST(Resampler, StopsAtTheLargestNumber) {
  const Points sheet = makeSheet();
  Resampler resampler(sheet, Points(sheet.size(), Vec3::UnitZ()), makeGridRings(kSide, kSide), 1.5, 17);
  EXPECT_EQ(17, resampler.update(moved(sheet, stretchThreefold)));
  EXPECT_EQ(0, resampler.update(moved(collectRest(sheet, resampler), stretchThreefold)));
  EXPECT_EQ(17u, resampler.insertedRest().size());
}

TEST(Resampler, LeavesErasedAndIsolatedPointsAlone) {
  const Points sheet = makeSheet();
  Resampler resampler(sheet, Points(sheet.size(), Vec3::UnitZ()), makeGridRings(kSide, kSide), 1.5, 100000);
  EXPECT_EQ(0, resampler.update(Points(sheet.size(), Vec3::Constant(std::nan("")))));
  cloud::Rings none;
  none.ring.offsets = {0, 0, 0};
  Resampler isolated({{0, 0, 0}, {1, 0, 0}}, Points(2, Vec3::UnitZ()), none, 1.5, 10);
  EXPECT_EQ(0, isolated.update({{0, 0, 0}, {100, 0, 0}}));
}

TEST(Resampler, HalvesLinksOfLinesWithoutASurface) {
  cloud::Rings line;
  line.ring.offsets = {0, 1, 3, 4};
  line.ring.items = {1, 0, 2, 1};
  const Points dense = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  Resampler resampler(dense, Points(3, Vec3::UnitZ()), line, 1.5, 10);
  EXPECT_EQ(2, resampler.update(moved(dense, stretchThreefold)));
  EXPECT_EQ(Vec3(0.5, 0.0, 0.0), resampler.insertedRest()[0]);
  EXPECT_EQ(Vec3(1.5, 0.0, 0.0), resampler.insertedRest()[1]);
}

TEST(Resampler, DoesNotDependOnTheNumberOfThreads) {
  const Points sheet = makeSheet();
  Points inserted[2];
  for (int run = 0; run < 2; ++run) {
    setNumThreads(run == 0 ? 1 : 3);
    Resampler resampler(sheet, Points(sheet.size(), Vec3::UnitZ()), makeGridRings(kSide, kSide), 1.3, 100000);
    updateUntilDone(sheet, resampler, [](const Vec3& p) { return Vec3(3.0 * p.x() * p.x(), p.y() * (1.0 + p.x()), p.x()); });
    inserted[run] = resampler.insertedRest();
  }
  setNumThreads(0);
  EXPECT_FALSE(inserted[0].empty());
  EXPECT_EQ(inserted[0], inserted[1]);
}

TEST(Resampler, RefusesWhatItCannotUse) {
  const Points sheet = makeSheet(), normals(sheet.size(), Vec3::UnitZ());
  const cloud::Rings rings = makeGridRings(kSide, kSide);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Resampler(sheet, {}, rings, 1.5, 10), InputError);
  EXPECT_THROW(Resampler(sheet, normals, {}, 1.5, 10), InputError);
  for (const double max_stretch : {1.0, 0.0, -2.0, nan}) {
    EXPECT_THROW(Resampler(sheet, normals, rings, max_stretch, 10), InputError);
  }
  EXPECT_THROW(Resampler(sheet, normals, rings, 1.5, -1), InputError);
  Resampler resampler(sheet, normals, rings, 1.5, 10);
  EXPECT_THROW(resampler.update(Points(3)), InputError);
}

}  // namespace
}  // namespace deformable_surface::transfer
