// Which pairs of vertices, edges and triangles are listed as near.
#include "deformable_surface/contact/pair_list.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "folded_sheets.h"

namespace deformable_surface::contact {
namespace {

using Found = std::vector<std::array<Index, 5>>;  // vertices, and 1 for edges

Found listNear(PairList& list, const Points& positions, double reach) {
  list.update(positions, reach);
  Found found;
  list.visitNear([&](const Pair& pair, double least) {
    EXPECT_LE(least, findClosest(pair, positions).gap.norm() + 1e-15);
    if (findClosest(pair, positions).gap.norm() < reach)
      found.push_back({pair.vertices[0], pair.vertices[1], pair.vertices[2], pair.vertices[3], pair.is_edges});
  });
  return found;
}

// By comparison of all pairs.
std::set<std::array<Index, 5>> findAll(const test::Sheets& sheets, const Points& positions, double reach) {
  std::set<std::array<Index, 5>> found;
  std::set<std::array<Index, 2>> edges;
  const auto offer = [&](Pair pair) {
    std::set<Index> distinct(pair.vertices.begin(), pair.vertices.end());
    if (distinct.size() == 4 && findClosest(pair, positions).gap.norm() < reach)
      found.insert({pair.vertices[0], pair.vertices[1], pair.vertices[2], pair.vertices[3], pair.is_edges});
  };
  for (const Triangle& t : sheets.triangles) {
    for (int k = 0; k < 3; ++k) edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    for (Index v = 0; v < static_cast<Index>(positions.size()); ++v) offer({{v, t[0], t[1], t[2]}, false, 0.0});
  }
  for (auto one = edges.begin(); one != edges.end(); ++one)
    for (auto other = std::next(one); other != edges.end(); ++other)
      offer({{(*one)[0], (*one)[1], (*other)[0], (*other)[1]}, true, 0.0});
  return found;
}

TEST(PairList, HasAllThatAreNearWhileTheyMove) {
  const test::Sheets sheets = test::makeSheets(2, 6, 0.004, 0.0005);
  PairList list(sheets.points, sheets.triangles, 0.002);
  Points positions = sheets.points;
  std::mt19937 generator(7);
  Points way;
  list.update(positions, 0.003);
  const Index num_at_first = list.numSearches();
  for (std::size_t i = 0; i < positions.size(); ++i) way.push_back(0.0002 * test::randomVector(generator));
  for (int step = 0; step < 40; ++step) {
    for (std::size_t i = 0; i < positions.size(); ++i)
      positions[i] += Vec3(0.01, 0.0, -0.02) + way[i] + (i >= 36 ? Vec3(0.0, 0.0, -0.0001) : Vec3(0.0, 0.0, 0.0));
    const double reach = step % 7 == 0 ? 0.012 : 0.003;
    const Found found = listNear(list, positions, reach);
    EXPECT_EQ(std::set(found.begin(), found.end()), findAll(sheets, positions, reach)) << step;
  }
  // The couples were not searched each time, although all points moved far together.
  EXPECT_LT(list.numSearches(), 20 * num_at_first);
}

TEST(PairList, IsInTheSameOrderWheneverItWasMade) {
  const test::Sheets sheets = test::makeSheets(3, 8, 0.003, 0.0005);
  Points positions = sheets.points;
  PairList lasting(sheets.points, sheets.triangles, 0.002);
  listNear(lasting, positions, 0.002);
  const Index num_searches = lasting.numSearches();
  std::mt19937 generator(2);
  for (Vec3& p : positions) p += 0.0003 * test::randomVector(generator);
  const Found found = listNear(lasting, positions, 0.002);
  EXPECT_EQ(lasting.numSearches(), num_searches);
  for (const int threads : {1, 2, 5}) {
    setNumThreads(threads);
    PairList fresh(sheets.points, sheets.triangles, 0.002);
    EXPECT_EQ(listNear(fresh, positions, 0.002), found) << threads;
  }
  setNumThreads(0);
}

TEST(PairList, SearchesOnlyWhereTheSurfaceDeforms) {
  const test::Sheets sheets = test::makeSheets(1, 30, 0.0, 0.0003);
  PairList list(sheets.points, sheets.triangles, 0.0001);
  list.update(sheets.points, 0.0002);
  const Index all = list.numSearches();
  EXPECT_GT(all, 200);
  Points positions = sheets.points;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) positions[30 * i + j] += Vec3(0.001, 0.001, 0.002);
  list.update(positions, 0.0002);
  EXPECT_GT(list.numSearches(), all);
  EXPECT_LT(list.numSearches(), all + all / 20);
}

// What a cover holds is left out; what it no longer holds comes back, wherever the points have gone meanwhile.
TEST(PairList, LeavesOutOnlyWhatIsCovered) {
  const test::Sheets sheets = test::makeSheets(2, 8, 0.004, 0.0005);
  PairList covered(sheets.points, sheets.triangles, 0.002);
  const Patches& patches = covered.patches();
  std::vector<Index> patch_of(sheets.points.size());
  for (Index p = 0; p < patches.size(); ++p) patches.visitVertices(p, [&](Index v) { patch_of[v] = p; });
  Cover cover;
  std::mt19937 generator(5);
  Points positions = sheets.points;
  std::size_t num_left_out = 0, num_found = 0;
  for (int step = 0; step < 30; ++step) {
    if (step % 3 == 0) {
      cover.clear(patches.size());
      for (const Index chart : {0, 1}) {
        std::vector<Index> some;
        for (Index p = 0; p < patches.size(); ++p)
          if (generator() % 2) some.push_back(p);
        cover.add(some, chart);
      }
      cover.end();
    }
    for (std::size_t i = 0; i < positions.size(); ++i)
      positions[i] += Vec3(0.0, 0.002, 0.0) + 0.0003 * test::randomVector(generator) + Vec3(0.0, 0.0, i >= 64 ? -0.0001 : 0.0);
    const double reach = step % 5 == 4 ? 0.006 : 0.003;
    const Cover* const given = step % 4 == 3 ? nullptr : &cover;
    const bool are_far = covered.areFar(positions, positions, {reach}, given);
    covered.update(positions, reach, given);
    std::set<std::array<Index, 5>> visited;
    covered.visitNear([&](const Pair& pair, double) {
      visited.insert({pair.vertices[0], pair.vertices[1], pair.vertices[2], pair.vertices[3], pair.is_edges});
    });
    for (const std::array<Index, 5>& found : findAll(sheets, positions, reach)) {
      // An edge is in the patch of its lower vertex, a triangle in that of its lowest.
      const Index one = patch_of[found[4] ? std::min(found[0], found[1]) : found[0]],
                  other = patch_of[found[4] ? std::min(found[2], found[3]) : std::min({found[1], found[2], found[3]})];
      const bool is_held = given && given->holds(one, other);
      EXPECT_EQ(visited.count(found), is_held ? 0u : 1u) << step;
      EXPECT_FALSE(are_far && !is_held) << step;
      ++(is_held ? num_left_out : num_found);
    }
  }
  EXPECT_GT(num_left_out, 100u);
  EXPECT_GT(num_found, 100u);
}

// Sheets that have not moved far need no look at their patches; those that the cover holds do not count.
TEST(PairList, IsQuickToTellWhatIsFar) {
  const test::Sheets sheets = test::makeSheets(2, 8, 0.02, 0.0005);
  PairList list(sheets.points, sheets.triangles, 0.002);
  std::vector<Index> all;
  for (Index p = 0; p < list.patches().size(); ++p) all.push_back(p);
  Cover cover;
  cover.clear(list.patches().size());
  cover.add(all, 0);
  cover.end();
  const PairList::Reach reach{0.002};
  EXPECT_FALSE(list.areFar(sheets.points, sheets.points, reach));
  list.update(sheets.points, reach.least);
  EXPECT_TRUE(list.areFar(sheets.points, sheets.points, reach));
  Points positions = sheets.points;
  for (Vec3& p : positions) p += Vec3(0.1, 0.2, 0.3);
  EXPECT_TRUE(list.areFar(positions, positions, reach));
  EXPECT_FALSE(list.areFar(positions, positions, reach, &cover));  // its nearest were not looked at
  positions.front() += Vec3(0.0, 0.0, 0.03);
  EXPECT_FALSE(list.areFar(positions, positions, reach));
  list.update(positions, reach.least, &cover);
  EXPECT_TRUE(list.areFar(positions, positions, reach, &cover));
  EXPECT_FALSE(list.areFar(positions, positions, reach));
  list.visitKnown(nullptr, [](const Pair&) {});
  EXPECT_FALSE(list.areFar(positions, positions, reach)) << "what is no longer covered was not looked at";
  list.update(positions, reach.least, &cover);
  EXPECT_TRUE(list.areFar(positions, positions, reach, &cover));
  cover.end();
  EXPECT_FALSE(list.areFar(positions, positions, reach, &cover));
}

TEST(PairList, KnowsNothingOfWhatIsCut) {
  const test::Sheets sheets = test::makeSheets(2, 8, 0.002, 0.0005);
  PairList list(sheets.points, sheets.triangles, 0.002);
  const auto count = [&] {
    Index num = 0;
    list.visitKnown(nullptr, [&](const Pair& pair) { num += findClosest(pair, sheets.points).gap.norm() < 0.003; });
    return num;
  };
  EXPECT_EQ(count(), 0);
  list.update(sheets.points, 0.003);
  EXPECT_GT(count(), 100);
  list.keepWhole(std::vector<char>(sheets.triangles.size(), 0));
  EXPECT_EQ(count(), 0);
}

TEST(PairList, HasAllThatComeWithinReachOfTheirWays) {
  const test::Sheets sheets = test::makeSheets(2, 6, 0.02, 0.0005);
  PairList list(sheets.points, sheets.triangles, 0.002);
  const PairList::Reach reach{0.001, 1.0, 0.05};
  Points positions = sheets.points, next = positions;
  std::mt19937 generator(3);
  int num_near = 0, num_far = 0;
  for (int step = 0; step < 60; ++step) {
    for (std::size_t i = 0; i < positions.size(); ++i)
      next[i] =
          positions[i] + 0.0003 * test::randomVector(generator) + (i >= 36 ? Vec3(0.0, 0.0, -0.0004) : Vec3(0.0, 0.0, 0.0002));
    const bool are_far = list.areFar(positions, next, reach);
    list.update(positions, next, reach);
    std::set<std::array<Index, 5>> visited;
    list.visitNear([&](const Pair& pair, double) {
      visited.insert({pair.vertices[0], pair.vertices[1], pair.vertices[2], pair.vertices[3], pair.is_edges});
    });
    for (const std::array<Index, 5>& found : findAll(sheets, positions, reach.most)) {
      const Pair pair{{found[0], found[1], found[2], found[3]}, found[4] != 0, 0.002};
      double way = 0.0;  // by which the two may come nearer
      for (int v = 0; v < pair.numFirst(); ++v)
        for (int w = pair.numFirst(); w < 4; ++w)
          way = std::max(way, ((next[found[v]] - positions[found[v]]) - (next[found[w]] - positions[found[w]])).norm());
      if (!(findClosest(pair, positions).gap.norm() < reach.of(way))) continue;
      EXPECT_FALSE(are_far) << step;
      EXPECT_EQ(visited.count(found), 1u) << step;
      ++num_near;
    }
    num_far += are_far;
    positions = next;
  }
  EXPECT_GT(num_near, 50);
  EXPECT_GT(num_far, 10);
}

TEST(PairList, TakesPartsThatAreNearAtRestForThinnerAndLeavesOutWhatCrosses) {
  test::Sheets sheets = test::makeSheets(2, 5, 0.001, 0.0);
  PairList list(sheets.points, sheets.triangles, 0.003);
  list.update(sheets.points, 0.003);
  Index num = 0;
  list.visitNear([&](const Pair& pair, double) {
    const double distance = findClosest(pair, sheets.points).gap.norm();
    EXPECT_LE(pair.thickness, 0.9 * distance + 1e-15);
    num += pair.thickness < 0.001;
  });
  EXPECT_GT(num, 25);

  test::Sheets crossing = test::makeSheets(2, 5, 0.0, 0.0);  // in one plane
  PairList none(crossing.points, crossing.triangles, 0.003);
  none.update(crossing.points, 0.003);
  none.visitNear([&](const Pair& pair, double) { EXPECT_GT(findClosest(pair, crossing.points).gap.norm(), 0.0); });
}

TEST(PairList, WhatPassesThroughOneLayerKeepsItsPairsWithOthers) {
  test::Sheets sheets = test::makeSheets(3, 5, 0.003, 0.0);
  constexpr Index kTip = 37;  // in the middle of the second layer
  sheets.points[kTip] += Vec3(0.0011, 0.0007, -0.0035);
  PairList list(sheets.points, sheets.triangles, 0.002);
  EXPECT_GT(list.numCrossed(), 0);
  list.update(sheets.points, 0.02);
  int num_of_tip = 0, num_below = 0;  // pairs of the tip with the third layer, and of the others with the first
  list.visitNear([&](const Pair& pair, double) {
    bool has_tip = false, has_first = false, has_third = false, has_other = false;
    for (const Index v : pair.vertices) {
      has_tip = has_tip || v == kTip;
      has_first = has_first || v < 25;
      has_third = has_third || v >= 50;
      has_other = has_other || (v >= 25 && v < 50 && v != kTip);
    }
    num_of_tip += has_tip && has_third;
    num_below += has_other && has_first && !has_tip;
    if (!has_tip || !has_first) return;
    for (const Index v : pair.vertices) EXPECT_NE(v, 12) << "a corner of what the tip's edges cross";
  });
  EXPECT_GT(num_of_tip, 10);
  EXPECT_GT(num_below, 50);
}

TEST(PairList, LeavesOutWhatIsCut) {
  test::Sheets sheets = test::makeSheets(2, 6, 0.004, 0.0005);
  PairList list(sheets.points, sheets.triangles, 0.002);
  const Found all = listNear(list, sheets.points, 0.006);
  std::vector<char> is_whole(sheets.triangles.size(), 1);
  test::Sheets rest = sheets;
  rest.triangles.clear();
  for (std::size_t t = 0; t < sheets.triangles.size(); ++t) {
    is_whole[t] = t % 3 != 0 && t > 20;
    if (is_whole[t]) rest.triangles.push_back(sheets.triangles[t]);
  }
  list.keepWhole(is_whole);
  const Found found = listNear(list, sheets.points, 0.006);
  EXPECT_LT(found.size(), all.size());
  EXPECT_EQ(std::set(found.begin(), found.end()), findAll(rest, sheets.points, 0.006));
  list.keepWhole(std::vector<char>(is_whole.size(), 1));
  EXPECT_EQ(listNear(list, sheets.points, 0.006), all);
}

TEST(PairList, SearchesNothingAgainWhenATriangleTears) {
  const test::Sheets sheets = test::makeSheets(2, 6, 0.004, 0.0005);
  PairList list(sheets.points, sheets.triangles, 0.002);
  listNear(list, sheets.points, 0.006);
  const Index num_searches = list.numSearches();
  std::vector<char> is_whole(sheets.triangles.size(), 1);
  test::Sheets rest = sheets;
  for (std::size_t torn = 0; torn < 5; ++torn) {
    is_whole[torn] = 0;
    rest.triangles.erase(rest.triangles.begin());
    list.keepWhole(is_whole);
    const Found found = listNear(list, sheets.points, 0.006);
    EXPECT_EQ(std::set(found.begin(), found.end()), findAll(rest, sheets.points, 0.006));
  }
  EXPECT_EQ(list.numSearches(), num_searches);
}

TEST(PairList, TakesNeighborsForThinnerThanOtherParts) {
  // A fan of thin triangles: the second and the last point are near each other, and joined to the first.
  const Points points{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {1.0, 0.001, 0.0}, {1.0, 0.002, 0.0}, {2.0, 0.0, 0.0}, {2.0, 0.002, 0.0}};
  PairList list(points, {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}, {2, 4, 5}}, 0.01);
  list.update(points, 0.01);
  int num = 0;
  list.visitNear([&](const Pair& pair, double) {
    const double at_rest = findClosest(pair, points).gap.norm();
    EXPECT_NEAR(pair.thickness, std::min(0.01, 0.5 * at_rest), 1e-12);
    ++num;
  });
  EXPECT_GT(num, 0);
}

TEST(PairList, LonePointsTouchTrianglesOnlyIfTheyAreTaken) {
  Points points{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.3, 0.3, 0.05}};
  for (const bool takes_lone_points : {true, false}) {
    PairList list(points, {{0, 1, 2}}, 0.01, takes_lone_points);
    list.update(points, 0.1);
    int num = 0;
    list.visitNear([&](const Pair& pair, double) { num += pair.vertices[0] == 3; });
    EXPECT_EQ(num, takes_lone_points ? 1 : 0);
  }
}

TEST(PairList, OfNothingIsEmpty) {
  PairList list({}, {}, 0.001);
  list.update({}, 0.001);
  list.visitNear([](const Pair&, double) { ADD_FAILURE(); });
}

TEST(PairList, RefusesWhatIsNoSurface) {
  EXPECT_THROW(PairList({Vec3::Zero()}, {{0, 1, 2}}, 0.001), InputError);
  EXPECT_THROW(PairList({Vec3::Zero()}, {}, 0.0), InputError);
}

}  // namespace
}  // namespace deformable_surface::contact
