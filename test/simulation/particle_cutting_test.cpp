// Knives in a sheet of oriented particles: what comes apart is what the way of the blade separates, in place, for good, until it
// is welded. The pieces, boundary loops and the Euler characteristic are counted here without the model's lists: over pairs and
// triangles of the sheet before the cut that do not cross the drawn way of the blade.
#include "../../src/simulation/state_hash.h"
#include "clouds.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/expectations.h"
#include "particles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <set>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using tool::Mode;
using tool::ToolParams;
using Line = std::vector<Vec2>;  // the way of a blade through the plane of the sheet

constexpr double kWidth = 1.0, kHeight = 0.8;  // m, of the sheet about the origin

double spacingOf(Index points) { return model::OrientedParticles::findSpacing(kWidth * kHeight, points); }

SceneParams stillParticles(Index points) {
  SceneParams p;
  p.model = "oriented_particles";
  p.cloud.shape = simulation::CloudParams::Shape::kLattice;
  p.cloud.points = points;
  p.cloud.size = Vec2(kWidth, kHeight);
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.gravity.setZero();
  p.material.damping = 5.0;
  const double a = spacingOf(points);
  p.material.bending_rigidity = 0.3 * p.material.young_modulus * p.material.thickness * a * a;
  return p;
}

/// jitter: of the spacing, by which points are moved along both axes.
cloud::PointCloud makeCloud(const SceneParams& p, double jitter = 0.0) {
  cloud::PointCloud cloud = io::makeShape(p.cloud);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> draw(-jitter, jitter);
  for (Vec3& x : cloud.positions) {
    x.x() += draw(random) * spacingOf(p.cloud.points);
    x.y() += draw(random) * spacingOf(p.cloud.points);
  }
  return cloud;
}

// ---- counted without the model ----

double side(const Vec2& a, const Vec2& b, const Vec2& p) { return (b - a).x() * (p - a).y() - (b - a).y() * (p - a).x(); }

bool crosses(const std::vector<Line>& ways, const Vec3& from, const Vec3& to) {
  const Vec2 a = from.head<2>(), b = to.head<2>();
  for (const Line& way : ways)
    for (std::size_t k = 0; k + 1 < way.size(); ++k)
      if (side(a, b, way[k]) * side(a, b, way[k + 1]) <= 0.0 && side(way[k], way[k + 1], a) * side(way[k], way[k + 1], b) <= 0.0)
        return true;
  return false;
}

/// m, from the nearest place of a segment to the ways.
double findDistance(const std::vector<Line>& ways, const Vec3& from, const Vec3& to) {
  constexpr int kSamples = 20;
  double least = 1e300;
  for (int k = 0; k <= kSamples; ++k) {
    const Vec2 p = (from + (to - from) * k / kSamples).head<2>();
    for (const Line& way : ways)
      for (std::size_t e = 0; e + 1 < way.size(); ++e) {
        const Vec2 along = way[e + 1] - way[e];
        const double share = std::min(1.0, std::max(0.0, (p - way[e]).dot(along) / along.squaredNorm()));
        least = std::min(least, (way[e] + share * along - p).norm());
      }
  }
  return least;
}

struct Union {
  std::vector<Index> parent;
  explicit Union(Index n) : parent(n) { std::iota(parent.begin(), parent.end(), 0); }
  Index find(Index i) { return parent[i] == i ? i : parent[i] = find(parent[i]); }
  void join(Index a, Index b) { parent[find(a)] = find(b); }
};

/// Sizes of the pieces, the largest first: pairs nearer than a bond is long that are joined.
std::vector<Index> countPieces(const Points& p, double bond, const std::function<bool(Index, Index)>& joined) {
  const Index n = static_cast<Index>(p.size());
  Union pieces(n);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < i; ++j)
      if ((p[i] - p[j]).squaredNorm() < bond * bond && joined(i, j)) pieces.join(i, j);
  std::map<Index, Index> sizes;
  for (Index i = 0; i < n; ++i) ++sizes[pieces.find(i)];
  std::vector<Index> sorted;
  for (const auto& [root, size] : sizes) sorted.push_back(size);
  std::sort(sorted.rbegin(), sorted.rend());
  return sorted;
}

struct Topology {
  int pieces = 0, euler = 0, loops = 0;
};

/// Of the Delaunay triangles of a flat sheet that do not cross the ways. A corner that the ways divide counts once on each side.
Topology countTopology(const Points& p, double spacing, const std::vector<Line>& ways) {
  const Index n = static_cast<Index>(p.size());
  const double longest = 1.75 * spacing;
  std::vector<std::vector<Index>> near(n);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j)
      if (j != i && (p[i] - p[j]).norm() < 2.0 * longest) near[i].push_back(j);
  std::vector<std::array<Index, 3>> triangles;
  for (Index i = 0; i < n; ++i)
    for (const Index j : near[i])
      for (const Index k : near[i]) {
        if (!(i < j && i < k) || !(side(p[i].head<2>(), p[j].head<2>(), p[k].head<2>()) > 0.0)) continue;
        if ((p[i] - p[j]).norm() > longest || (p[i] - p[k]).norm() > longest || (p[j] - p[k]).norm() > longest) continue;
        const Vec3 u = p[j] - p[i], v = p[k] - p[i], w = u.cross(v);
        const Vec3 center = p[i] + (u.squaredNorm() * v.cross(w) + v.squaredNorm() * w.cross(u)) / (2.0 * w.squaredNorm());
        const double radius = (center - p[i]).norm();
        bool is_empty = radius < longest;
        for (const Index q : near[i]) is_empty = is_empty && (q == j || q == k || (p[q] - center).norm() > (1.0 - 1e-9) * radius);
        if (!is_empty || crosses(ways, p[i], p[j]) || crosses(ways, p[j], p[k]) || crosses(ways, p[k], p[i])) continue;
        triangles.push_back({i, j, k});
      }
  std::map<std::pair<Index, Index>, std::pair<Index, int>> edges;  // from lower to higher: triangle and its edge
  const Index num_triangles = static_cast<Index>(triangles.size());
  Union pieces(num_triangles), corners(3 * num_triangles);
  int num_edges = 0;
  for (Index t = 0; t < num_triangles; ++t)
    for (int e = 0; e < 3; ++e) {
      const Index a = triangles[t][e], b = triangles[t][(e + 1) % 3];
      const auto [found, is_new] = edges.insert({{std::min(a, b), std::max(a, b)}, {t, e}});
      if (is_new) {
        ++num_edges;
        continue;
      }
      const auto [other, f] = found->second;  // whose edge goes the other way
      pieces.join(t, other);
      corners.join(3 * t + e, 3 * other + (f + 1) % 3);
      corners.join(3 * t + (e + 1) % 3, 3 * other + f);
    }
  Topology found;
  for (Index t = 0; t < num_triangles; ++t) found.pieces += pieces.find(t) == t;
  for (Index c = 0; c < 3 * num_triangles; ++c) found.euler += corners.find(c) == c;
  found.euler += num_triangles - num_edges;
  found.loops = 2 * found.pieces - found.euler;  // of a surface without handles
  return found;
}

// ---- what the model has ----

const model::OrientedParticles& particlesOf(const Simulation& s) {
  return static_cast<const model::OrientedParticles&>(s.model());
}

std::vector<Index> countModelPieces(const Simulation& s) {
  const model::State& state = s.state();
  const model::ParticleCuts& cuts = particlesOf(s).cuts();
  return countPieces(state.positions, latticeOf(s).pair.cutoff,
                     [&](Index i, Index j) { return cuts.mayBind(state.traits[i].id, state.traits[j].id); });
}

Topology topologyOf(Simulation& s) {
  const auto count = [&](const char* name) { return static_cast<int>(simulation::computeQuantity(name, s)); };
  EXPECT_EQ(count("isolated"), 0);
  return {count("components"), count("euler_characteristic"), count("boundary_loops")};
}

void expectSame(const Topology& found, const Topology& expected) {
  EXPECT_EQ(found.pieces, expected.pieces);
  EXPECT_EQ(found.loops, expected.loops);
  EXPECT_EQ(found.euler, expected.euler);
}

double findLargestMotion(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

// ---- knives ----

ToolParams makeKnife(const char* id) {
  ToolParams knife;
  knife.id = id;
  knife.mode = Mode::kCut;
  return knife;
}

/// A thin tool upright on the sheet along a line, from time 0 at a speed in m/s.
ToolParams scalpel(const char* id, double width, const Line& way, double speed, double begin = 0.0) {
  ToolParams knife = makeKnife(id);
  knife.shape.kind = geometry::Solid::Kind::kCylinder;
  knife.shape.radius = 0.5 * width;
  knife.shape.height = 1.0;
  for (std::size_t k = 0; k < way.size(); ++k) {
    if (k > 0) begin += (way[k] - way[k - 1]).norm() / speed;
    knife.path.push_back({begin, Vec3(way[k].x(), way[k].y(), 0.1)});
  }
  knife.start = knife.path.front().time;
  knife.end = begin;
  return knife;
}

/// Comes down onto the sheet along a line from (x, y) to (x2, y2).
ToolParams chopper(const char* id, double width, const Vec2& from, const Vec2& to, double speed) {
  ToolParams knife = makeKnife(id);
  const Vec2 along = to - from, middle = 0.5 * (from + to);
  knife.shape.kind = geometry::Solid::Kind::kBox;
  knife.shape.size = Vec3(along.norm(), width, 0.4);
  const double half = 0.5 * std::atan2(along.y(), along.x());
  const Vec4 turn(0.0, 0.0, std::sin(half), std::cos(half));
  knife.path = {{0.0, Vec3(middle.x(), middle.y(), 0.3), turn}, {0.3 / speed, Vec3(middle.x(), middle.y(), 0.0), turn}};
  knife.end = 0.3 / speed + 0.02;
  return knife;
}

Line arc(const Vec2& center, double radius, double from, double to, int pieces = 40) {
  Line line;
  for (int k = 0; k <= pieces; ++k) {
    const double angle = from + (to - from) * k / pieces;
    line.push_back(center + radius * Vec2(std::cos(angle), std::sin(angle)));
  }
  return line;
}

double findEnd(const std::vector<ToolParams>& tools) {
  double end = 0.0;
  for (const ToolParams& tool : tools) end = std::max(end, tool.end);
  return end;
}

struct Cut {
  const char* name;
  Index points;
  double jitter, step;
  std::vector<ToolParams> tools;
  std::vector<Line> ways;
  int pieces, loops;
};

std::vector<Cut> listCuts() {
  const auto a = [](Index n) { return spacingOf(n); };
  const Line across{{0.013, -0.6}, {0.013, 0.6}}, along{{-0.7, 0.021}, {0.7, 0.021}}, half{{0.013, -0.6}, {0.013, 0.007}};
  const Line slit{{-0.25, 0.03}, {0.22, -0.05}}, slanting{{-0.7, -0.31}, {0.7, 0.37}};
  const Line bow = arc(Vec2(0.0, -0.62), 0.55, 0.02, kPi - 0.02), ring = arc(Vec2(0.02, 0.01), 0.25, 0.1, 0.1 + 2.0 * kPi);
  Line wave;
  for (int k = 0; k <= 60; ++k) wave.push_back({-0.7 + 1.4 * k / 60.0, 0.12 * std::sin(0.15 * k)});
  const Line into{{0.7, 0.021}, {0.012, 0.021}};  // ends a little beyond `across`
  const auto chop = [](const char* id, double width, const Line& way, double speed) {
    return chopper(id, width, way.front(), way.back(), speed);
  };
  return {
      {"scalpel across", 400, 0.0, 0.01, {scalpel("k", 0.12 * a(400), across, 2.0)}, {across}, 2, 2},
      {"thick scalpel across", 400, 0.3, 0.01, {scalpel("k", 3.0 * a(400), across, 2.0)}, {across}, 2, 2},
      {"slow scalpel", 400, 0.15, 0.002, {scalpel("k", 0.5 * a(400), across, 1.0)}, {across}, 2, 2},
      {"scalpel in one step", 400, 0.3, 0.05, {scalpel("k", 0.5 * a(400), across, 50.0)}, {across}, 2, 2},
      {"thin box comes down", 600, 0.0, 0.01, {chop("k", 0.12 * a(600), across, 2.0)}, {across}, 2, 2},
      {"thick box comes down", 600, 0.3, 0.01, {chop("k", 3.0 * a(600), across, 2.0)}, {across}, 2, 2},
      {"box in one step", 600, 0.15, 0.02, {chop("k", 1.0 * a(600), slanting, 30.0)}, {slanting}, 2, 2},
      {"box comes down slowly", 200, 0.15, 0.002, {chop("k", 0.5 * a(200), slanting, 0.5)}, {slanting}, 2, 2},
      {"stops midway", 600, 0.0, 0.01, {scalpel("k", 0.5 * a(600), half, 1.0)}, {half}, 1, 1},
      {"stops midway, disordered", 1500, 0.3, 0.01, {scalpel("k", 1.5 * a(1500), half, 5.0)}, {half}, 1, 1},
      {"a slit within", 600, 0.15, 0.01, {scalpel("k", 0.3 * a(600), slit, 1.0)}, {slit}, 1, 2},
      {"a slit by a box", 900, 0.0, 0.005, {chop("k", 2.0 * a(900), slit, 1.0)}, {slit}, 1, 2},
      {"a bow", 600, 0.0, 0.01, {scalpel("k", 0.3 * a(600), bow, 2.0)}, {bow}, 2, 2},
      {"a bow, slow and disordered", 900, 0.3, 0.005, {scalpel("k", 2.0 * a(900), bow, 1.0)}, {bow}, 2, 2},
      {"a wave", 1500, 0.15, 0.01, {scalpel("k", 0.6 * a(1500), wave, 3.0)}, {wave}, 2, 2},
      {"a ring", 900, 0.0, 0.01, {scalpel("k", 0.4 * a(900), ring, 2.0)}, {ring}, 2, 3},
      {"a ring, disordered", 3000, 0.3, 0.01, {scalpel("k", 1.0 * a(3000), ring, 5.0)}, {ring}, 2, 3},
      {"a cross",
       600,
       0.15,
       0.01,
       {scalpel("k", 0.3 * a(600), across, 2.0), scalpel("l", 0.3 * a(600), along, 2.0, 0.7)},
       {across, along},
       4,
       4},
      {"two boxes at once",
       900,
       0.3,
       0.01,
       {chop("k", 0.3 * a(900), across, 2.0), chop("l", 1.0 * a(900), slanting, 2.0)},
       {across, slanting},
       4,
       4},
      {"one meets another",
       600,
       0.0,
       0.01,
       {scalpel("k", 0.3 * a(600), across, 2.0), scalpel("l", 0.3 * a(600), into, 2.0, 0.7)},
       {across, into},
       3,
       3},
      {"3000 particles", 3000, 0.15, 0.01, {scalpel("k", 0.5 * a(3000), slanting, 2.0)}, {slanting}, 2, 2},
      {"200 particles", 200, 0.3, 0.01, {scalpel("k", 0.5 * a(200), along, 2.0)}, {along}, 2, 2},
  };
}

TEST(ParticleCutting, WhatComesApartIsWhatTheWayOfTheBladeSeparates) {
  for (const Cut& cut : listCuts()) {
    SCOPED_TRACE(cut.name);
    SceneParams p = stillParticles(cut.points);
    p.integrator.time_step = cut.step;
    p.tools = cut.tools;
    Simulation s(p, makeCloud(p, cut.jitter));
    const Points before = s.state().positions;
    const double a = latticeOf(s).spacing, bond = latticeOf(s).pair.cutoff;
    expectSame(countTopology(before, a, {}), {1, 1, 1});
    run(s, static_cast<int>(std::ceil((findEnd(cut.tools) + 0.1) / cut.step)));

    const Topology expected = countTopology(before, a, cut.ways);
    EXPECT_EQ(expected.pieces, cut.pieces);
    EXPECT_EQ(expected.loops, cut.loops);
    expectSame(topologyOf(s), expected);
    const auto isWhole = [&](Index i, Index j) { return !crosses(cut.ways, before[i], before[j]); };
    std::vector<Index> apart = countPieces(before, bond, isWhole);
    apart.erase(std::remove(apart.begin(), apart.end(), 1), apart.end());  // the model leaves none alone
    EXPECT_EQ(apart.size(), static_cast<std::size_t>(cut.pieces));
    EXPECT_EQ(countModelPieces(s).size(), static_cast<std::size_t>(cut.pieces));

    // Bonds go where the way crosses them, and nowhere else. A particle on the way itself may go with either side, and a blade
    // is half a spacing long.
    const model::ParticleCuts& cuts = particlesOf(s).cuts();
    Index crossed = 0, kept = 0;
    for (Index i = 0; i < s.state().size(); ++i)
      for (Index j = 0; j < i; ++j) {
        if (!((before[i] - before[j]).norm() < 0.95 * bond)) continue;
        const bool is_whole = cuts.mayBind(i, j), should = isWhole(i, j);
        crossed += !should;
        kept += !should && is_whole;
        if (should && !is_whole) EXPECT_LT(findDistance(cut.ways, before[i], before[j]), 0.3 * a);
      }
    EXPECT_LE(kept, crossed / 10);
    EXPECT_EQ(s.state().next_id, static_cast<Index>(before.size()));  // no one added
    EXPECT_EQ(s.state().positions.size(), before.size());             // nor removed
    EXPECT_LT(findLargestMotion(before, s.state().positions), 0.3 * a);
  }
}

// ---- after the cut ----

const Line kAcross{{0.013, -0.6}, {0.013, 0.6}};

/// Cut along x = 0.013 within 0.3 s.
SceneParams cutSheet(Index points = 400) {
  SceneParams p = stillParticles(points);
  p.tools = {scalpel("knife", 0.3 * spacingOf(points), kAcross, 5.0)};
  return p;
}

/// Carries what lies at the left or right end of the sheet along, from 0.3 s on, a second from place to place.
ToolParams hand(const char* id, bool is_right, const std::vector<Vec3>& moves) {
  ToolParams tool;
  tool.id = id;
  tool.mode = Mode::kMove;
  tool.shape.kind = geometry::Solid::Kind::kBox;
  tool.shape.size = Vec3(0.3, 2.0, 0.3);
  const Vec3 place((is_right ? 1.0 : -1.0) * 0.45, 0.0, 0.0);
  tool.start = 0.3;
  tool.path = {{0.3, place}};
  for (const Vec3& move : moves) tool.path.push_back({tool.path.back().time + 1.0, place + move});
  return tool;
}

/// The ends stay, or one of them moves.
std::vector<ToolParams> hands(const std::vector<Vec3>& moves) { return {hand("left", false, {}), hand("right", true, moves)}; }

std::size_t countPlacedPieces(const Simulation& s) {
  return countPieces(s.state().positions, latticeOf(s).pair.cutoff, [](Index, Index) { return true; }).size();
}

TEST(ParticleCutting, EdgesThatMeetAgainStayApart) {
  for (const double slide : {0.0, 0.5, 3.0}) {
    SCOPED_TRACE(slide);
    SceneParams p = cutSheet();
    const double a = spacingOf(400);
    const Vec3 away(0.1, 0.0, 0.0), back(-0.2 * a, slide * a, 0.0), apart(0.1, slide * a, 0.0);
    for (const ToolParams& tool : hands({away, Vec3(0.1, slide * a, 0.0), back, back, apart})) p.tools.push_back(tool);
    Simulation s(p, makeCloud(p));
    run(s, 330);
    EXPECT_EQ(countPlacedPieces(s), 1u);  // they touch
    EXPECT_EQ(countModelPieces(s).size(), 2u);
    expectSame(topologyOf(s), {2, 2, 2});
    run(s, 200);
    EXPECT_EQ(countPlacedPieces(s), 2u);  // and come apart
    expectSame(topologyOf(s), {2, 2, 2});
  }
}

// Pairs that lie on both sides of a slanted way and almost along it must not keep a bond.
TEST(ParticleCutting, SidesOfASlantedCutStayApartWhenTheySlideAlongIt) {
  struct Slide {
    double from, to;  // m, x of the way at the lower and the upper edge
    Index points;
    double width;  // m
    double speed;  // m/s
    double slide;  // m, along y
    double jitter;
  };
  for (const Slide& c : {Slide{-0.04, 0.09, 800, 0.09, 5.0, 0.18, 0.0}, Slide{0.06, -0.06, 800, 0.015, 5.0, -0.15, 0.0},
                         Slide{0.02, 0.15, 600, 0.05, 5.0, 0.2, 0.0}, Slide{-0.02, -0.16, 700, 0.008, 20.0, -0.17, 0.0},
                         Slide{-0.09, 0.16, 400, 0.006, 8.0, 0.21, 0.1}, Slide{0.07, 0.17, 700, 0.02, 5.0, 0.2, 0.1}}) {
    SCOPED_TRACE(std::to_string(c.from) + " to " + std::to_string(c.to));
    SceneParams p = stillParticles(c.points);
    p.tools = {scalpel("knife", c.width, {{c.from, -0.6}, {c.to, 0.6}}, c.speed)};
    const Vec3 along(c.slide * (c.to - c.from) / 1.2, c.slide, 0.0);
    for (const ToolParams& tool : hands({along, along + Vec3(0.1, 0.0, 0.0)})) p.tools.push_back(tool);
    Simulation s(p, makeCloud(p, c.jitter));
    run(s, 30);
    EXPECT_EQ(countModelPieces(s).size(), 2u);
    run(s, 220);
    EXPECT_EQ(countModelPieces(s).size(), 2u);
    EXPECT_EQ(countPlacedPieces(s), 2u);
  }
}

TEST(ParticleCutting, HeatOnBothSidesWelds) {
  for (const double offset : {0.0, -4.0}) {  // spacings: on the seam; on one side of it
    SCOPED_TRACE(offset);
    SceneParams p = cutSheet();
    const double a = spacingOf(400);
    p.oriented_particles.cooling = 20.0;
    ToolParams iron;
    iron.id = "iron";
    iron.mode = Mode::kHeat;
    iron.strength = 600.0;
    iron.shape.kind = geometry::Solid::Kind::kBox;
    iron.shape.size = Vec3(7.0 * a, 2.0, 0.3);
    iron.path = {{0.0, Vec3(0.013 + offset * a, 0.0, 0.0)}};
    iron.start = 0.4;
    iron.end = 0.6;
    p.tools.push_back(iron);
    for (const ToolParams& tool : hands({Vec3::Zero(), Vec3(0.02, 0.0, 0.0)})) p.tools.push_back(tool);
    Simulation s(p, makeCloud(p));
    run(s, 120);
    const bool is_welded = offset == 0.0;
    expectSame(topologyOf(s), is_welded ? Topology{1, 1, 1} : Topology{2, 2, 2});
    EXPECT_EQ(particlesOf(s).cuts().isEmpty(), is_welded);  // as if it had never been cut
    run(s, 120);
    EXPECT_EQ(countModelPieces(s).size(), is_welded ? 1u : 2u);
    Points ends;
    double gap = 0.0;  // the widest between successive particles along x: the weld bears a strain of 2 %
    for (const Vec3& x : s.state().positions) ends.push_back(x);
    std::sort(ends.begin(), ends.end(), [](const Vec3& u, const Vec3& v) { return u.x() < v.x(); });
    for (std::size_t i = 1; i < ends.size(); ++i) gap = std::max(gap, ends[i].x() - ends[i - 1].x());
    if (is_welded) {
      EXPECT_LT(gap, 0.56 * a);
    } else {
      EXPECT_GT(gap, 0.56 * a);
    }
  }
}

/// The two sides of a cut by the ids of particles, also of those that are born later: they belong to their parents' side.
class SideWatch {
 public:
  /// The cut along x = 0.013 has been made, and nothing has moved yet.
  explicit SideWatch(const Simulation& s) : numbers_(s.state().next_id) {
    for (Index i = 0; i < s.state().size(); ++i) side_[s.state().traits[i].id] = s.input().positions[i].x() < 0.013 ? 0 : 1;
  }

  /// Runs on, and looks at every birth.
  void run(Simulation& s, int steps) {
    for (int k = 0; k < steps; ++k) {
      test::run(s, 1);
      for (const model::ParticleTraits& born : s.state().traits) {
        if (born.id < numbers_) continue;
        std::set<int> sides;
        for (const Index parent : born.parents) {
          const auto found = side_.find(parent);
          if (found != side_.end()) sides.insert(found->second);
        }
        ASSERT_FALSE(sides.empty()) << born.id;
        ++births_[*sides.begin()];
        across_ += sides.size() > 1;
        side_[born.id] = *sides.begin();
      }
      numbers_ = s.state().next_id;
    }
  }

  /// Bonds between the two sides.
  Index countJoined(const Simulation& s) const {
    const model::State& state = s.state();
    const model::ParticleCuts& cuts = particlesOf(s).cuts();
    const double bond = latticeOf(s).pair.cutoff;
    Index joined = 0;
    for (Index i = 0; i < state.size(); ++i)
      for (Index j = 0; j < i; ++j) {
        const Index a = state.traits[i].id, b = state.traits[j].id;
        if (side_.at(a) == side_.at(b) || !cuts.mayBind(a, b)) continue;
        joined += (state.positions[i] - state.positions[j]).squaredNorm() < bond * bond;
      }
    return joined;
  }

  Index births(int side) const { return births_[side]; }
  Index across() const { return across_; }  // births with parents on both sides

 private:
  Index numbers_;
  std::map<Index, int> side_;
  Index births_[2] = {0, 0}, across_ = 0;
};

TEST(ParticleCutting, GrowthDoesNotBridgeACutThatIsPulledOpen) {
  for (const bool is_cut : {true, false}) {
    SCOPED_TRACE(is_cut);
    SceneParams p = cutSheet();
    p.oriented_particles.stretching = true;
    p.oriented_particles.growing = model::Growing::kGaps;
    p.oriented_particles.rest_shape = model::RestShape::kFlat;
    if (!is_cut) p.tools.clear();
    for (const ToolParams& tool : hands({Vec3(0.05, 0.0, 0.0), Vec3(0.1, 0.0, 0.0), Vec3(0.3, 0.0, 0.0)}))
      p.tools.push_back(tool);
    Simulation s(p, makeCloud(p));
    run(s, 30);
    SideWatch watch(s);
    watch.run(s, 310);
    if (is_cut) {
      EXPECT_EQ(watch.across(), 0);  // a cut gap is no room
      EXPECT_EQ(watch.countJoined(s), 0);
    } else {
      EXPECT_GT(watch.births(0) + watch.births(1), 0);  // a whole sheet that is stretched as far grows
    }
  }
}

TEST(ParticleCutting, ParticlesBornBesideACutBelongToItsSide) {
  SceneParams p = cutSheet();
  p.oriented_particles.stretching = true;
  p.oriented_particles.rest_shape = model::RestShape::kFlat;
  p.oriented_particles.exponents = Vec2(4.0, 2.0);
  p.oriented_particles.growth.min_gap = 1.3;
  p.oriented_particles.growth.clearance = 0.65;
  const double a = spacingOf(400);
  // Both halves are drawn out along the cut, so that there are births on both sides of it.
  ToolParams low, high;
  for (ToolParams* tool : {&low, &high}) {
    const double sign = tool == &low ? -1.0 : 1.0;
    *tool = hand(tool == &low ? "low" : "high", true, {});
    tool->shape.size = Vec3(2.0, 0.2, 0.3);
    tool->path = {{0.3, Vec3(0.0, 0.35 * sign, 0.0)}, {2.3, Vec3(0.0, (0.35 + 6.0 * a) * sign, 0.0)}};
  }
  p.tools.push_back(low);
  p.tools.push_back(high);
  Simulation s(p, makeCloud(p));
  run(s, 30);
  SideWatch watch(s);
  watch.run(s, 210);
  EXPECT_GT(watch.births(0), 0);
  EXPECT_GT(watch.births(1), 0);
  EXPECT_EQ(watch.across(), 0);
  EXPECT_EQ(watch.countJoined(s), 0);
  const model::State& state = s.state();
  const model::ParticleCuts& cuts = particlesOf(s).cuts();
  Index born_beside = 0;
  for (Index i = 0; i < state.size(); ++i)
    born_beside += state.traits[i].parents[0] != model::kNoParent && cuts.isCut(state.traits[i].id);
  EXPECT_GT(born_beside, 0);
}

// Two states that differ by a cut alone go different ways.
TEST(ParticleCutting, ACutIsInTheHashAndComesBackWithASnapshot) {
  const SceneParams p = cutSheet();
  Simulation s(p, makeCloud(p));
  const simulation::Snapshot before = s.snapshot();
  const std::uint64_t whole = s.stateHash();
  run(s, 40);
  ASSERT_FALSE(particlesOf(s).cuts().isEmpty());
  EXPECT_EQ(s.statistics().state_hash, s.stateHash());
  EXPECT_NE(simulation::hashState(s.state()), s.stateHash());
  const std::uint64_t hash = s.stateHash();
  const simulation::Snapshot after = s.snapshot();
  s.restore(before);
  EXPECT_EQ(s.stateHash(), whole);
  s.restore(after);
  EXPECT_EQ(s.stateHash(), hash);
  EXPECT_FALSE(particlesOf(s).cuts().isEmpty());
}

// By hand or by ~grow_surface, beside a cut: no particle joins its two sides.
TEST(ParticleCutting, EditsAndGrownSurfacesBesideACutDoNotBridgeIt) {
  SceneParams p = cutSheet();
  Simulation s(p, makeCloud(p));
  run(s, 40);
  ASSERT_EQ(countModelPieces(s).size(), 2u);
  const double a = spacingOf(400);
  // Particles of both sides go, and the holes are filled anew: one by hand, the others by growth.
  simulation::ParticleEdit edit;
  edit.action = simulation::ParticleAction::kDelete;
  const Index first = s.state().size();
  for (Index i = 0; i < first; ++i)
    if ((s.state().positions[i] - Vec3(0.013, 0.0, 0.0)).norm() < 1.2 * a) edit.ids.push_back(s.state().traits[i].id);
  ASSERT_GE(edit.ids.size(), 3u);
  s.editParticles(edit);
  edit = simulation::ParticleEdit();
  edit.action = simulation::ParticleAction::kAdd;
  edit.positions = {Vec3(0.013 - 0.6 * a, 0.0, 0.0)};
  edit.orientations = {Quaternion::Identity()};
  const std::vector<Index> added = s.editParticles(edit);
  ASSERT_EQ(added.size(), 1u);
  const model::ParticleCuts cuts = particlesOf(s).cuts();
  EXPECT_TRUE(cuts.isCut(added[0]));
  for (Index i = 0; i < s.state().size(); ++i)
    if (s.state().positions[i].x() > 0.013) {
      EXPECT_FALSE(cuts.mayBind(added[0], s.state().traits[i].id)) << s.state().positions[i].transpose() / a;
    }
  EXPECT_EQ(countModelPieces(s).size(), 2u);
  model::GrowthParams growth;
  growth.max_gap = 4.0;
  growth.min_gap = 1.6;
  s.growSurface(growth);
  EXPECT_GT(s.state().next_id, first + 1);
  EXPECT_EQ(countModelPieces(s).size(), 2u);
  run(s, 100);
  EXPECT_EQ(countModelPieces(s).size(), 2u);
}

TEST(ParticleCutting, PointsOfTheCloudGoWithTheirSide) {
  SceneParams p = cutSheet(4000);
  p.tools = {scalpel("knife", 0.01, kAcross, 5.0)};
  for (const ToolParams& tool : hands({Vec3(0.2, 0.0, 0.0)})) p.tools.push_back(tool);
  p.material = cutSheet(400).material;
  p.simplification.method = simulation::SceneParams().simplification.method;
  p.simplification.target_points = 400;
  Simulation s(p, makeCloud(p));
  const Points before = s.surface(true).positions;
  run(s, 180);
  const Points after = s.surface(true).positions;
  Index wrong = 0;
  constexpr double kSettled = 0.09;  // m, by which simplified particles find their places meanwhile
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double moved = after[i].x() - before[i].x();
    EXPECT_TRUE(std::abs(moved) < kSettled || std::abs(moved - 0.2) < kSettled) << before[i].transpose() << ": " << moved;
    if ((moved > 0.1) != (before[i].x() > 0.013)) {
      ++wrong;
      EXPECT_LT(std::abs(before[i].x() - 0.013), latticeOf(s).spacing);
    }
  }
  EXPECT_LT(wrong, 150);  // of 240 within half a spacing on either side
}

TEST(ParticleCutting, HashesDoNotDependOnThreadsSnapshotsForksAndResets) {
  SceneParams p = cutSheet(900);
  p.tools.push_back(scalpel("second", 0.01, {{-0.7, 0.021}, {0.3, 0.021}}, 4.0, 0.1));
  p.oriented_particles.stretching = true;
  for (const ToolParams& tool : hands({Vec3(0.06, 0.05, 0.0), Vec3(0.0, 0.1, 0.02)})) p.tools.push_back(tool);
  const cloud::PointCloud cloud = makeCloud(p, 0.2);
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 2, 3}) {
    setNumThreads(threads);
    Simulation s(p, cloud);
    for (int k = 0; k < 100; ++k) {
      run(s, 1);
      if (threads == 1) hashes.push_back(s.stateHash());
      ASSERT_EQ(s.stateHash(), hashes[k]) << threads << " threads, step " << k;
    }
  }
  setNumThreads(0);
  Simulation s(p, cloud);
  for (const int at : {3, 17, 40, 60}) {
    s.reset();
    EXPECT_TRUE(particlesOf(s).cuts().isEmpty());
    run(s, at);
    const simulation::Snapshot snapshot = s.snapshot();
    Simulation fork = s.fork();
    run(s, 100 - at);
    EXPECT_EQ(s.stateHash(), hashes.back());
    run(fork, 100 - at);
    EXPECT_EQ(fork.stateHash(), hashes.back());
    s.restore(snapshot);
    run(s, 100 - at);
    EXPECT_EQ(s.stateHash(), hashes.back());
  }
}

TEST(ParticleCutting, AWarmKnifeWeakensBondsAsPublishedAndCutsNone) {
  SceneParams p = cutSheet();
  p.tools[0].strength = 800.0;
  Simulation s(p, makeCloud(p));
  run(s, 40);
  EXPECT_TRUE(particlesOf(s).cuts().isEmpty());
  double hottest = 0.0;
  for (const model::ParticleTraits& particle : s.state().traits) hottest = std::max(hottest, particle.temperature);
  EXPECT_EQ(hottest, 800.0);
}

}  // namespace
}  // namespace deformable_surface::test
