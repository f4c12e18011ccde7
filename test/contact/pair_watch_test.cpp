// One look at the lists serves many sub-steps, and misses nothing.
#include "deformable_surface/contact/pair_watch.h"

#include <gtest/gtest.h>

#include <array>

#include "folded_sheets.h"

namespace deformable_surface::contact {
namespace {

using Found = std::vector<std::array<Index, 5>>;  // vertices, and 1 for edges

void add(const Pair& pair, const Closest& closest, double way, Found& found) {
  if (closest.gap.norm() < pair.reachFor(way))
    found.push_back({pair.vertices[0], pair.vertices[1], pair.vertices[2], pair.vertices[3], pair.is_edges});
}

// Two sheets, with a list that is watched and one that is looked through each time.
struct Watching {
  const test::Sheets sheets = test::makeSheets(2, 10, 0.0015, 0.0005);
  Points positions = sheets.points;
  PairList watched{sheets.points, sheets.triangles, 0.001}, list{sheets.points, sheets.triangles, 0.001};
  PairWatch watch{watched};
  std::mt19937 generator{3};

  Points shake(double size) {
    Points velocities;
    for (std::size_t i = 0; i < positions.size(); ++i) velocities.push_back(size * test::randomVector(generator));
    return velocities;
  }
  Points moved(const Points& ways) const {
    Points next = positions;
    for (std::size_t i = 0; i < next.size(); ++i) next[i] += ways[i];
    return next;
  }
  // Whether the same pairs, in the same order, are within reach. Nothing is watched where the lists cost less. next: (n) m, where
  // the points are on their way to.
  void expectSame(double way, const Points& next) {
    if (!watch.ensure(positions, way, positions, next)) return;
    ++num_watched;
    Found of_watch, of_list;
    AppendedParts<Found::value_type> parts;
    watch.collectNear(positions, way, of_watch, parts, [&](const Pair& pair, const Closest& closest, Found& found) {
      EXPECT_EQ(closest.gap, findClosest(pair, positions).gap);
      ++num_measured;
      add(pair, closest, way, found);
    });
    list.update(positions, list.largestReachFor(way));
    list.visitNear([&](const Pair& pair, double) { add(pair, findClosest(pair, positions), way, of_list); });
    EXPECT_EQ(of_watch, of_list);
    const auto isNear = [&](const Pair& pair, double least) {
      const double distance = findClosest(pair, positions).gap.norm();
      EXPECT_LE(least, distance + 1e-15);
      return distance < pair.reachFor(way);
    };
    EXPECT_EQ(watch.isAnyNear(way, isNear), !of_list.empty());
    num_found += of_list.size();
  }
  int num_watched = 0;
  std::size_t num_found = 0, num_measured = 0;
};

TEST(PairWatch, FindsWhatTheListsFindInAnyMotion) {
  Watching w;
  Points ways = w.shake(0.00005);
  for (int step = 0; step < 300; ++step) {
    // Smooth, with a noise that grows; all points drift together, too.
    const Points noise = w.shake(2e-7 * step);
    for (std::size_t i = 0; i < ways.size(); ++i) ways[i] = 0.97 * ways[i] + noise[i] + Vec3(0.0, 0.001, 0.0);
    const Points next = w.moved(ways);
    w.expectSame(step % 5 == 0 ? 0.001 : 0.0002, step % 3 == 0 ? w.positions : next);
    for (Vec3& way : ways) way.y() -= 0.001;
    w.positions = next;
  }
  EXPECT_GT(w.num_watched, 150);
  EXPECT_GT(w.num_found, 1000u);
}

TEST(PairWatch, OneLookServesAsLongAsPointsKeepTheirVelocities) {
  Watching w;
  const Points ways = w.shake(0.00002);
  for (int step = 0; step < 40; ++step) {
    const Points next = w.moved(ways);
    w.expectSame(0.0, next);
    w.positions = next;
  }
  EXPECT_EQ(w.num_watched, 40);
  EXPECT_EQ(w.watch.numLooks(), 1);
}

// The sheets form a wedge, and its open end sways by 3 mm.
TEST(PairWatch, OneLookServesWhereOnlyFarPartsMove) {
  Watching w;
  const Points rest = w.positions;
  for (int step = 0; step < 40; ++step) {
    for (std::size_t i = rest.size() / 2; i < rest.size(); ++i) {
      const double x = rest[i].x();
      w.positions[i].z() = rest[i].z() - 0.0012 + 0.3 * x + 0.3 * std::sin(step) * x * x;
    }
    w.expectSame(0.001, w.positions);
  }
  EXPECT_EQ(w.num_watched, 40);
  EXPECT_GT(w.num_found, 0u);
  EXPECT_EQ(w.watch.numLooks(), 1);
}

// Pairs that are a little farther apart are ruled out by a plane between their two parts.
TEST(PairWatch, MeasuresLittleMoreThanWhatIsWithinReach) {
  Watching w;
  const Points ways = w.shake(0.00002);
  for (int step = 0; step < 20; ++step) {
    const Points next = w.moved(ways);
    w.expectSame(0.0, next);
    w.positions = next;
  }
  EXPECT_GT(w.num_found, 100u);
  EXPECT_LT(w.num_measured, 3 * w.num_found);
}

TEST(PairWatch, LooksSeldomAtWhatNoPredictionServes) {
  Watching w;
  for (int step = 0; step < 100; ++step) {
    w.positions = w.moved(w.shake(0.002));
    w.expectSame(0.0, w.positions);
  }
  EXPECT_LT(w.watch.numLooks(), 20);
}

TEST(PairWatch, LooksAgainOnceTheListsHoldOtherPairs) {
  Watching w;
  w.expectSame(0.0, w.positions);
  std::vector<char> is_whole(w.sheets.triangles.size(), 1);
  for (std::size_t t = 0; t < is_whole.size(); t += 2) is_whole[t] = 0;
  w.watched.keepWhole(is_whole);
  w.list.keepWhole(is_whole);
  w.watch.forget();
  w.expectSame(0.0, w.positions);
  EXPECT_EQ(w.watch.numLooks(), 2);
}

}  // namespace
}  // namespace deformable_surface::contact
