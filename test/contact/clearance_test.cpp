// What is proven to stay apart stays apart.
#include "deformable_surface/contact/clearance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "../support/crossings.h"
#include "folded_sheets.h"

namespace deformable_surface::contact {
namespace {

constexpr double kDistance = 0.002;

// The least distance of primitives without a common vertex, by comparison of all pairs.
double findLeast(const std::vector<Triangle>& triangles, const Points& positions) {
  std::set<std::array<Index, 2>> edges;
  double least = std::numeric_limits<double>::infinity();
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    for (Index v = 0; v < static_cast<Index>(positions.size()); ++v)
      if (std::find(t.begin(), t.end(), v) == t.end())
        least =
            std::min(least, findClosestToTriangle(positions[v], positions[t[0]], positions[t[1]], positions[t[2]]).gap.norm());
  }
  for (const auto& [a, b] : edges)
    for (const auto& [c, d] : edges)
      if (a < c && b != c && b != d)
        least = std::min(least, findClosestOfEdges(positions[a], positions[b], positions[c], positions[d]).gap.norm());
  return least;
}

Points move(const Points& positions, const Points& velocities, double time) {
  Points moved = positions;
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += time * velocities[i];
  return moved;
}

Points still(std::size_t n) { return Points(n, Vec3::Zero()); }

// A sheet of 0.1 m rolled to an arc of this angle, rad.
Points roll(const Points& flat, double angle) {
  Points rolled = flat;
  for (Vec3& p : rolled) {
    const double radius = 0.1 / angle, at = p.x() / radius;
    p = Vec3((radius - p.z()) * std::sin(at), p.y(), radius - (radius - p.z()) * std::cos(at));
  }
  return rolled;
}

// Holes, notches at the boundary, parts that hang together by a point, points without triangles.
std::vector<Triangle> dropSome(const std::vector<Triangle>& triangles, std::mt19937& generator) {
  std::vector<Triangle> kept;
  for (const Triangle& t : triangles)
    if (generator() % 12 != 0) kept.push_back(t);
  return kept;
}

TEST(Clearance, IsRightForAnyMotion) {
  std::mt19937 generator(7);
  const auto between = [&](double low, double high) { return low + 0.5 * (high - low) * (1.0 + test::uniform(generator)); };
  int num_proven = 0, num_apart = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const int side = 3 + generator() % 4;
    const test::Sheets sheet = test::makeSheets(1, side, 0.0, between(0.0, 0.2) * 0.1 / (side - 1), trial);
    const Index n = static_cast<Index>(sheet.points.size());
    const std::vector<Triangle> triangles = trial % 2 ? dropSome(sheet.triangles, generator) : sheet.triangles;
    Clearance clearance(sheet.points, triangles, kDistance);
    // Bends, shears, waves and noise.
    Points positions = roll(sheet.points, between(0.01, 4.0));
    const double wave = between(0.0, 0.015), noise = between(0.0, 0.25) * 0.1 / (side - 1);
    for (Vec3& p : positions) {
      p += Vec3(between(0.0, 1.0) * p.y(), 0.0, wave * std::sin(60.0 * p.y())) + noise * test::randomVector(generator);
      p = test::someRotation() * p;
    }
    Points velocities = still(n);
    const double speed = between(0.0, 0.01);
    const Vec3 spin = 0.3 * test::randomVector(generator);
    for (Index i = 0; i < n; ++i) velocities[i] = spin.cross(positions[i]) + speed * test::randomVector(generator);
    if (!clearance.prove(positions, velocities, 1.0)) continue;
    ++num_proven;
    num_apart += clearance.isApart();
    for (int look = 0; look < 12; ++look) {
      // The corners of the tolerance are the worst places.
      const Points predicted = move(positions, velocities, look / 11.0);
      Points aside = predicted, shifted = predicted;
      double size = 0.01;
      const auto shift = [&] {
        shifted = aside;
        for (Index i = 0; i < n; ++i) shifted[i] = predicted[i] + size * (aside[i] - predicted[i]);
      };
      for (Index i = 0; i < n; ++i)
        for (int k = 0; k < 3; ++k) aside[i][k] += generator() % 2 ? 1.0 : -1.0;
      for (shift(); !clearance.staysUncrossed(shifted, predicted) && size > 1e-9; shift()) size *= 0.95;
      if (size > 1e-9) {
        EXPECT_TRUE(test::findCrossings(shifted, triangles).empty()) << trial;
      }
      if (!clearance.isApart()) continue;
      EXPECT_GT(findLeast(triangles, predicted), kDistance) << trial;
      for (; !clearance.isApartAt(shifted) && size > 1e-9; shift()) size *= 0.95;
      if (size > 1e-9) {
        EXPECT_GT(findLeast(triangles, shifted), kDistance) << trial;
      }
    }
  }
  EXPECT_GT(num_proven, 300);
  EXPECT_GT(num_apart, 150);
  EXPECT_LT(num_proven, 1200);
}

TEST(Clearance, HoldsUntilTheSurfaceIsUprightSomewhere) {
  const test::Sheets sheet = test::makeSheets(1, 16, 0.0, 0.0);
  Clearance clearance(sheet.points, sheet.triangles, kDistance);
  const Points at_rest = still(sheet.points.size());
  EXPECT_TRUE(clearance.prove(roll(sheet.points, 2.0), at_rest, 0.0));
  EXPECT_TRUE(clearance.isApart());
  // The altitude of the outermost triangles, seen from above, is that at rest times cos(1.4) = 0.17: less than the distance.
  EXPECT_TRUE(clearance.prove(roll(sheet.points, 2.8), at_rest, 0.0));
  EXPECT_FALSE(clearance.isApart());
  EXPECT_FALSE(clearance.prove(roll(sheet.points, 3.5), at_rest, 0.0));
}

TEST(Clearance, KnowsHowLongItHolds) {
  const test::Sheets sheet = test::makeSheets(1, 8, 0.0, 0.0);
  Clearance clearance(sheet.points, sheet.triangles, kDistance);
  Points velocities = still(sheet.points.size());
  for (std::size_t i = 0; i < velocities.size(); ++i) velocities[i] = Vec3(0.0, 5.0, -20.0 * sheet.points[i].x());
  ASSERT_TRUE(clearance.prove(sheet.points, velocities, 0.01));
  EXPECT_TRUE(clearance.staysUncrossed(sheet.points, move(sheet.points, velocities, 0.005)));
  EXPECT_TRUE(clearance.isApartAt(move(sheet.points, velocities, 0.01)));
  EXPECT_FALSE(clearance.isApartAt(move(sheet.points, velocities, 0.02)));
  // A displacement of all across the motion brings nothing nearer.
  EXPECT_TRUE(clearance.isApartAt(move(sheet.points, Points(sheet.points.size(), Vec3::UnitX()), 0.5)));
  Points one = move(sheet.points, velocities, 0.005);
  one[20].z() += 0.01;
  EXPECT_FALSE(clearance.staysUncrossed(sheet.points, one));
  EXPECT_FALSE(clearance.staysUncrossed(one, sheet.points));
  one[20].z() = std::nan("");
  EXPECT_FALSE(clearance.staysUncrossed(sheet.points, one));
  EXPECT_FALSE(clearance.prove(one, velocities, 0.01));
  Points sudden = velocities;
  sudden[20].x() = std::nan("");
  EXPECT_FALSE(clearance.prove(sheet.points, sudden, 0.01));
  EXPECT_FALSE(clearance.isApart());
  ASSERT_TRUE(clearance.prove(sheet.points, velocities, 0.01));
  clearance.forget();
  EXPECT_FALSE(clearance.isApart());
  EXPECT_FALSE(clearance.staysUncrossed(sheet.points, sheet.points));
}

// A proof for a long time serves the steps within it.
TEST(Clearance, HoldsForManySteps) {
  const test::Sheets sheet = test::makeSheets(1, 8, 0.0, 0.0);
  Clearance clearance(sheet.points, sheet.triangles, kDistance);
  Points velocities = still(sheet.points.size());
  for (std::size_t i = 0; i < velocities.size(); ++i) velocities[i] = Vec3(0.0, 5.0, -10.0 * sheet.points[i].x());
  EXPECT_FALSE(clearance.staysApart(sheet.points, velocities, 0.0));
  ASSERT_TRUE(clearance.prove(sheet.points, velocities, 0.01));
  const std::shared_ptr<const ClearMotion> proven = clearance.proven();
  for (const double time : {0.0, 0.003, 0.008})
    EXPECT_TRUE(clearance.staysApart(move(sheet.points, velocities, time), velocities, 0.002)) << time;
  EXPECT_FALSE(clearance.staysApart(move(sheet.points, velocities, 0.008), velocities, 0.01));
  Points others = velocities;
  others[20].z() += 100.0;
  EXPECT_TRUE(clearance.staysApart(sheet.points, others, 0.0));
  EXPECT_FALSE(clearance.staysApart(sheet.points, others, 0.001));
  others[20].z() = std::nan("");
  EXPECT_FALSE(clearance.staysApart(sheet.points, others, 0.001));
  // A clearance that has never tried, with what another one has proven.
  Clearance second(sheet.points, sheet.triangles, kDistance);
  second.setProven(proven);
  EXPECT_TRUE(second.staysApart(sheet.points, velocities, 0.01));
  // What is held elsewhere is not overwritten.
  const Points from = proven->from;
  ASSERT_TRUE(clearance.prove(roll(sheet.points, 1.0), still(from.size()), 0.0));
  EXPECT_EQ(proven->from, from);
  EXPECT_TRUE(second.staysApart(sheet.points, velocities, 0.01));
}

TEST(Clearance, DoesNotTakeARampForASheet) {
  // A spiral ramp of one and a quarter turns: all of it faces up, but its ends lie over each other.
  Points points;
  std::vector<Triangle> triangles;
  constexpr Index kAlong = 31;
  for (Index i = 0; i < kAlong; ++i)
    for (const double radius : {0.05, 0.1}) {
      const double angle = 2.5 * M_PI * i / (kAlong - 1);
      points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.001 * angle);
    }
  for (Index i = 0; i + 1 < kAlong; ++i) {
    triangles.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    triangles.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  }
  EXPECT_FALSE(Clearance(points, triangles, kDistance).prove(points, still(points.size()), 0.0));
}

TEST(Clearance, KeepsPartsApart) {
  const test::Sheets sheets = test::makeSheets(2, 6, 0.01, 0.0);
  Clearance clearance(sheets.points, sheets.triangles, kDistance);
  Points velocities = still(sheets.points.size());
  EXPECT_TRUE(clearance.prove(sheets.points, velocities, 0.0));
  EXPECT_TRUE(clearance.isApart());
  for (std::size_t i = 0; i < 36; ++i) velocities[i] = Vec3(0.0, 0.0, 1.0);
  EXPECT_TRUE(clearance.prove(sheets.points, velocities, 0.009));
  EXPECT_FALSE(clearance.isApart());
  EXPECT_FALSE(clearance.prove(sheets.points, velocities, 0.011));
}

TEST(Clearance, NeedsTrianglesAndABoundary) {
  test::Sheets sheet = test::makeSheets(1, 4, 0.0, 0.0);
  sheet.points.emplace_back(0.5, 0.5, 0.5);  // in no triangle
  EXPECT_FALSE(Clearance(sheet.points, sheet.triangles, kDistance).prove(sheet.points, still(17), 0.0));
  const Points corners{{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.0, 0.1, 0.0}, {0.0, 0.0, 0.1}};
  const std::vector<Triangle> closed{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  EXPECT_FALSE(Clearance(corners, closed, kDistance).prove(corners, still(4), 0.0));
  // Two triangles with one corner in common.
  const Points bow{{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.1, 0.1, 0.0}, {-0.1, 0.0, 0.0}, {-0.1, -0.1, 0.0}};
  EXPECT_FALSE(Clearance(bow, {{0, 1, 2}, {0, 3, 4}}, kDistance).prove(bow, still(5), 0.0));
  EXPECT_FALSE(Clearance({}, {}, kDistance).prove({}, {}, 0.0));
}

// Primitives of a surface, and in which patch they are.
struct Primitives {
  std::vector<std::pair<Index, Index>> vertices, edges, triangles;  // index and patch

  explicit Primitives(const PairList& list) {
    for (Index p = 0; p < list.patches().size(); ++p) {
      list.patches().visitVertices(p, [&](Index i) { vertices.emplace_back(i, p); });
      list.patches().visitEdges(p, [&](Index i) { edges.emplace_back(i, p); });
      list.patches().visitTriangles(p, [&](Index i) { triangles.emplace_back(i, p); });
    }
  }
};

// The least distance of primitives without a common vertex that the cover holds, and whether two of them cross.
std::pair<double, bool> lookUnder(const Cover& cover, const PairList& list, const Points& x) {
  const Primitives all(list);
  double least = std::numeric_limits<double>::infinity();
  bool crosses = false;
  for (const auto& [t, q] : all.triangles) {
    const Triangle& corner = list.triangles()[t];
    const auto has = [&](Index v) { return std::find(corner.begin(), corner.end(), v) != corner.end(); };
    for (const auto& [v, p] : all.vertices)
      if (cover.holds(p, q) && !has(v))
        least = std::min(least, findClosestToTriangle(x[v], x[corner[0]], x[corner[1]], x[corner[2]]).gap.norm());
    for (const auto& [e, p] : all.edges) {
      const auto& [a, b] = list.edges()[e];
      if (cover.holds(p, q) && !has(a) && !has(b))
        crosses = crosses || test::passesThrough(x[a], x[b], x[corner[0]], x[corner[1]], x[corner[2]]);
    }
  }
  for (const auto& [e, p] : all.edges)
    for (const auto& [f, q] : all.edges) {
      const auto& [a, b] = list.edges()[e];
      const auto& [c, d] = list.edges()[f];
      if (cover.holds(p, q) && a != c && a != d && b != c && b != d)
        least = std::min(least, findClosestOfEdges(x[a], x[b], x[c], x[d]).gap.norm());
    }
  return {least, crosses};
}

// Sheets that are rolled up, waved and crumpled, so that the whole has no proof.
TEST(Clearance, IsRightForPartsOfAnyMotion) {
  std::mt19937 generator(11);
  const auto between = [&](double low, double high) { return low + 0.5 * (high - low) * (1.0 + test::uniform(generator)); };
  int num_apart = 0, num_none = 0;
  for (int trial = 0; trial < 36; ++trial) {
    const int side = 12 + generator() % 5;
    const double edge = 0.1 / (side - 1);
    const test::Sheets sheet = test::makeSheets(1, side, 0.0, between(0.0, 0.15) * edge, trial);
    const Index n = static_cast<Index>(sheet.points.size());
    const std::vector<Triangle> triangles = trial % 3 == 2 ? dropSome(sheet.triangles, generator) : sheet.triangles;
    const double distance = between(0.02, 0.25) * edge;
    const PairList list(sheet.points, triangles, distance / 1.5);
    Clearance clearance(sheet.points, triangles, distance, &list.patches());
    Points positions = roll(sheet.points, between(1.0, 6.0));
    const double wave = between(0.0, 0.015), noise = between(0.0, 0.12) * edge;
    for (Vec3& p : positions)
      p = test::someRotation() * (p + Vec3(0.0, 0.0, wave * std::sin(80.0 * p.y())) + noise * test::randomVector(generator));
    Points velocities = still(n);
    const Vec3 spin = 0.2 * test::randomVector(generator), drift = test::randomVector(generator);
    for (Index i = 0; i < n; ++i) velocities[i] = drift + spin.cross(positions[i]) + 0.1 * edge * test::randomVector(generator);
    if (!clearance.proveParts(positions, velocities, 1.0)) {
      ++num_none;
      continue;
    }
    for (const double time : {0.0, 0.4, 1.0}) {
      const Points predicted = move(positions, velocities, time);
      // The corners of the tolerance are the worst places.
      Points corner = predicted, shifted = predicted;
      for (Vec3& p : corner)
        for (int k = 0; k < 3; ++k) p[k] += generator() % 2 ? 1.0 : -1.0;
      double size = edge;
      const auto shift = [&] {
        for (Index i = 0; i < n; ++i) shifted[i] = predicted[i] + size * (corner[i] - predicted[i]);
      };
      const Cover* cover = nullptr;
      for (shift(); !(cover = clearance.partsApart(shifted)) && size > 1e-9; shift()) size *= 0.9;
      ASSERT_NE(cover, nullptr);
      EXPECT_GT(lookUnder(*cover, list, shifted).first, distance) << trial;
      ++num_apart;
    }
  }
  EXPECT_GT(num_apart, 35);
  EXPECT_GT(num_none, 2);
}

// Closed surfaces have no proof as a whole.
TEST(Clearance, KnowsPartsOfAClosedSurface) {
  const test::Sheets ball = test::makeBall(20, 40);
  const PairList list(ball.points, ball.triangles, 1e-4);
  Clearance clearance(ball.points, ball.triangles, 1.5e-4, &list.patches());
  const Points at_rest = still(ball.points.size());
  EXPECT_FALSE(clearance.hasOutline());
  EXPECT_FALSE(clearance.prove(ball.points, at_rest, 1.0));
  ASSERT_TRUE(clearance.proveParts(ball.points, at_rest, 1.0));
  const Cover& cover = *clearance.partsApart(ball.points);
  for (Index p = 0; p < list.patches().size(); ++p) EXPECT_TRUE(cover.holds(p, p)) << p;
  Points inside_out = ball.points;
  inside_out[40] = Vec3::Constant(std::nan(""));
  EXPECT_EQ(clearance.partsApart(inside_out), nullptr);
  clearance.forgetParts();
  EXPECT_EQ(clearance.partsApart(ball.points), nullptr);
}

// A quick look in place of the proof holds while no two points move against each other by the slack.
TEST(Clearance, LooksWhereNothingCanBeProven) {
  const test::Sheets ball = test::makeBall(11, 20);
  const PairList list(ball.points, ball.triangles, 1e-4);
  Clearance clearance(ball.points, ball.triangles, 1.5e-4);
  constexpr double kSlack = 0.003;
  clearance.lookInstead(list.patches(), kSlack, false);
  ASSERT_TRUE(clearance.prove(ball.points, still(ball.points.size()), 1.0));
  Points moved = ball.points;
  for (Vec3& x : moved) x += Vec3(0.3, 0.1, 0.0);
  EXPECT_TRUE(clearance.isApartAt(moved));
  EXPECT_TRUE(clearance.staysUncrossed(ball.points, moved));
  moved[3] += Vec3(0.5 * kSlack, 0.0, 0.0);
  EXPECT_TRUE(clearance.isApartAt(moved));
  moved[3] += Vec3(0.6 * kSlack, 0.0, 0.0);
  EXPECT_FALSE(clearance.isApartAt(moved));
  Points pressed = ball.points;
  for (Vec3& x : pressed) x.z() *= 0.01;
  EXPECT_FALSE(clearance.prove(pressed, still(ball.points.size()), 1.0));
  EXPECT_EQ(clearance.proven(), nullptr);
  ASSERT_TRUE(clearance.prove(ball.points, still(ball.points.size()), 1.0));
  clearance.setLooks(false);
  EXPECT_EQ(clearance.proven(), nullptr);
  EXPECT_FALSE(clearance.prove(ball.points, still(ball.points.size()), 1.0));
}

}  // namespace
}  // namespace deformable_surface::contact
