// The transfer is exact where it must be (rest, translations, linear fields, rotations). Its convergence, the published weights,
// and neighbourhoods that span no plane.
#include "deformable_surface/transfer/transfer.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <random>

namespace {
std::atomic<long> num_allocations{0};
}

// Not inlined: the compiler takes the inlined pair for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++num_allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace deformable_surface::transfer {
namespace {

using Normals = std::vector<Eigen::Vector3f>;

struct Surface {
  Points positions, normals;
};

// side x side points of the unit square, moved at random within their cells, on the graph of height(x, y).
template <class Height>
Surface makeGraph(Index side, unsigned seed, const Height& height) {
  std::mt19937 random(seed);
  Surface surface;
  for (Index i = 0; i < side; ++i) {
    for (Index j = 0; j < side; ++j) {
      const double x = (i + 0.2 + 0.6 * random() / 4294967296.0) / side, y = (j + 0.2 + 0.6 * random() / 4294967296.0) / side;
      const double step = 1e-6;
      surface.positions.emplace_back(x, y, height(x, y));
      surface.normals.push_back(Vec3(-(height(x + step, y) - height(x - step, y)) / (2 * step),
                                     -(height(x, y + step) - height(x, y - step)) / (2 * step), 1.0)
                                    .normalized());
    }
  }
  return surface;
}

Surface makeSheet(Index side, unsigned seed) {
  return makeGraph(side, seed, [](double, double) { return 0.0; });
}

Surface makeWave(Index side, unsigned seed) {
  return makeGraph(side, seed, [](double x, double y) { return 0.1 * std::sin(4.0 * x) * std::cos(3.0 * y); });
}

Transfer makeTransfer(const Surface& dense, const Surface& simulation, const TransferParams& options = {}) {
  const std::vector<char> usable(simulation.positions.size(), 1);
  return Transfer(dense.positions, dense.normals, simulation.positions, usable, options);
}

template <class Map>
Points moved(const Points& points, const Map& map) {
  Points result;
  for (const Vec3& p : points) result.push_back(map(p));
  return result;
}

double findLargestDistance(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double distance = (a[i] - b[i]).norm();
    if (!(distance <= largest)) largest = distance;  // NaN stays
  }
  return largest;
}

const Mat3 kRotation = Eigen::AngleAxisd(2.5, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();

TEST(Transfer, KeepsTheRestPositionsToTheBit) {
  const Surface dense = makeWave(30, 1), simulation = makeWave(9, 2);
  Points now;
  Normals normals;
  makeTransfer(dense, simulation).apply(simulation.positions, now, normals);
  EXPECT_EQ(dense.positions, now);
  for (std::size_t i = 0; i < now.size(); ++i) EXPECT_LT((normals[i].cast<double>() - dense.normals[i]).norm(), 1e-6);
}

TEST(Transfer, TranslatesExactlyHoweverFar) {
  const Surface dense = makeWave(30, 1), simulation = makeWave(9, 2);
  const Vec3 far(1000.0, -2000.0, 500.0);
  const auto map = [&](const Vec3& p) { return Vec3(p + far); };
  Points now;
  Normals normals;
  makeTransfer(dense, simulation).apply(moved(simulation.positions, map), now, normals);
  EXPECT_LT(findLargestDistance(moved(dense.positions, map), now), 1e-11);
  for (std::size_t i = 0; i < now.size(); ++i) EXPECT_LT((normals[i].cast<double>() - dense.normals[i]).norm(), 1e-6);
}

TEST(Transfer, ReproducesLinearFieldsOnSheetsForEveryWeighting) {
  const Surface dense = makeSheet(30, 1), simulation = makeSheet(9, 2);
  Mat3 gradient;
  gradient << 1.3, 0.2, 0.0, -0.4, 0.7, 0.0, 0.5, -0.6, 1.0;
  const auto map = [&](const Vec3& p) { return Vec3(gradient * p + Vec3(0.3, 0.1, -0.2)); };
  const Vec3 normal = gradient.col(0).cross(gradient.col(1));
  for (const Weighting weighting : {Weighting::kCompact, Weighting::kGaussian}) {
    for (const Index k : {4, 8, 11, 64}) {
      TransferParams options;
      options.weighting = weighting;
      options.k = k;
      const Transfer transfer = makeTransfer(dense, simulation, options);
      Points now;
      Normals normals;
      transfer.apply(moved(simulation.positions, map), now, normals);
      EXPECT_LT(findLargestDistance(moved(dense.positions, map), now), 2e-6) << "k " << k;
      for (const auto& n : normals) EXPECT_LT((n.cast<double>() - normal.normalized()).norm(), 2e-5) << "k " << k;
      std::vector<float> ratio;
      transfer.areaRatio(moved(simulation.positions, map), ratio);
      ASSERT_EQ(dense.positions.size(), ratio.size());
      for (float r : ratio) EXPECT_NEAR(normal.norm(), r, 2e-5) << "k " << k;
    }
  }
}

TEST(Transfer, RotatesCurvedSurfacesRigidly) {
  const Surface dense = makeWave(30, 1), simulation = makeWave(8, 2);
  const auto map = [&](const Vec3& p) { return Vec3(kRotation * p + Vec3(3.0, 2.0, 1.0)); };
  for (const Index k : {8, 13}) {
    TransferParams options;
    options.k = k;
    const Transfer transfer = makeTransfer(dense, simulation, options);
    Points now;
    Normals normals;
    transfer.apply(moved(simulation.positions, map), now, normals);
    EXPECT_LT(findLargestDistance(moved(dense.positions, map), now), 2e-6);
    for (std::size_t i = 0; i < now.size(); ++i) {
      EXPECT_LT((normals[i].cast<double>() - kRotation * dense.normals[i]).norm(), 3e-5);
    }
    std::vector<float> ratio;
    transfer.areaRatio(moved(simulation.positions, map), ratio);
    for (float r : ratio) EXPECT_NEAR(1.0f, r, 3e-5f);
  }
}

TEST(Transfer, ConvergesOnSmoothDeformations) {
  // A sheet is bent into a wave and stretched; halving the spacing twice.
  const Surface dense = makeSheet(40, 1);
  const auto map = [](const Vec3& p) {
    return Vec3(p.x() + 0.1 * std::sin(2.0 * p.y()), 1.2 * p.y(), 0.15 * std::sin(4.0 * p.x()) * std::cos(3.0 * p.y()));
  };
  const auto findNormal = [&](const Vec3& p) {
    const double step = 1e-6;
    const Vec3 dx = map(p + step * Vec3::UnitX()) - map(p - step * Vec3::UnitX());
    const Vec3 dy = map(p + step * Vec3::UnitY()) - map(p - step * Vec3::UnitY());
    return Vec3(dx.cross(dy).normalized());
  };
  double error[2], normal_error[2];
  for (int level = 0; level < 2; ++level) {
    const Surface simulation = makeSheet(level == 0 ? 12 : 48, 3);
    Points now;
    Normals normals;
    makeTransfer(dense, simulation).apply(moved(simulation.positions, map), now, normals);
    error[level] = normal_error[level] = 0.0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      error[level] += (now[i] - map(dense.positions[i])).norm() / now.size();
      normal_error[level] += (normals[i].cast<double>() - findNormal(dense.positions[i])).norm() / now.size();
    }
  }
  // Second order for positions and first for normals make a sixteenth and a quarter.
  EXPECT_LT(error[0], 5e-3);
  EXPECT_LT(error[1], error[0] / 12.0);
  EXPECT_LT(normal_error[1], normal_error[0] / 3.0);
}

// Also if a few are not simulated and ride along.
TEST(Transfer, WhereNearlyAllPointsAreSimulatedTheseAreAtTheirPlaces) {
  Points rest, normals;
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 9; ++j) {
      rest.emplace_back(i, j, 0.3 * std::sin(0.7 * i));
      normals.push_back(Vec3(-0.21 * std::cos(0.7 * i), 0.0, 1.0).normalized());
    }
  rest.emplace_back(4.0, 4.0, 2.0);
  normals.emplace_back(0.0, 0.0, 1.0);
  Points simulated(rest.rbegin() + 1, rest.rend());  // in another order
  const Transfer transfer(rest, normals, simulated, std::vector<char>(simulated.size(), 1), {});
  std::mt19937 random(1);
  for (Vec3& x : simulated) x += Vec3(random() % 7, random() % 7, random() % 7) / 16.0;
  Points dense;
  std::vector<Eigen::Vector3f> turned;
  transfer.apply(simulated, dense, turned);
  for (std::size_t i = 0; i < simulated.size(); ++i) EXPECT_LT((dense[i] - simulated[simulated.size() - 1 - i]).norm(), 1e-6);
}

TEST(Transfer, FindsTheLargestValueOfWhatEachPointFollows) {
  Points simulation, dense;
  for (int i = 0; i < 12; ++i) simulation.emplace_back(i, 0.3 * (i % 2), 0.0);
  for (int i = 0; i < 23; ++i) dense.emplace_back(0.5 * i, 0.1, 0.0);
  TransferParams params;
  params.k = 3;
  const Transfer transfer(dense, Points(dense.size(), Vec3::UnitZ()), simulation, std::vector<char>(12, 1), params);
  std::vector<float> values(12, 0.5f), largest;
  values[4] = 2.0f;
  transfer.findLargest(values, largest);
  ASSERT_EQ(largest.size(), dense.size());
  for (Index i = 0; i < transfer.numDense(); ++i) {
    const std::vector<Index> sources = transfer.sourcesOf(i);
    const bool follows = std::find(sources.begin(), sources.end(), 4) != sources.end();
    EXPECT_EQ(largest[i], follows ? 2.0f : 0.5f) << i;
  }
}

TEST(Transfer, WeighsByThePublishedGaussian) {
  // One dense point in the middle of four with a quadratic field: the symmetric fit is the weighted mean, known by hand.
  const Points simulation = {{1, 0, 0}, {-1, 0, 0}, {0, 2, 0}, {0, -2, 0}};
  TransferParams options;
  options.k = 4;
  options.weighting = Weighting::kGaussian;
  options.gaussian_width = 1.5;
  const Transfer transfer({{0, 0, 0}}, {{0, 0, 1}}, simulation, std::vector<char>(4, 1), options);
  Points now;
  transfer.apply({{1, 0, 1}, {-1, 0, 1}, {0, 2, 4}, {0, -2, 4}}, now);
  const double near = std::exp(-1.0 / 2.25), far = std::exp(-4.0 / 2.25);
  EXPECT_NEAR((near * 1.0 + far * 4.0) / (near + far), now[0].z(), 1e-6);
}

TEST(Transfer, GaussianDoesNotVanishFarFromAllPoints) {
  TransferParams options;
  options.weighting = Weighting::kGaussian;
  options.gaussian_width = 1e-3;
  const Surface simulation = makeSheet(6, 1);
  const Transfer transfer({{50.0, 0.5, 0.0}}, {{0, 0, 1}}, simulation.positions, std::vector<char>(36, 1), options);
  Points now;
  transfer.apply(moved(simulation.positions, [](const Vec3& p) { return Vec3(p + Vec3(1, 2, 3)); }), now);
  EXPECT_LT((now[0] - Vec3(51.0, 2.5, 3.0)).norm(), 1e-9);
}

TEST(Transfer, IsLinearAlongLinesAndConstantAcross) {
  Points line, dense;
  for (int i = 0; i < 20; ++i) line.emplace_back(0.1 * i, 0.0, 0.0);
  for (int i = 0; i < 30; ++i) dense.emplace_back(0.05 * i, 0.02, 0.0);
  const Transfer transfer(dense, Points(30, Vec3::UnitZ()), line, std::vector<char>(20, 1), {});
  EXPECT_EQ(30, transfer.numDegenerate());
  const auto map = [](const Vec3& p) { return Vec3(1.5 * p.x() + 1.0, p.y(), p.z() + 0.3 * p.x()); };
  Points now;
  transfer.apply(moved(line, map), now);
  EXPECT_LT(findLargestDistance(moved(dense, map), now), 1e-6);
}

TEST(Transfer, IsTheMeanWhereNeighborsDoNotSpread) {
  // One simulation point, and several that coincide as seen from the dense point.
  for (const Points& simulation : {Points{{1, 0, 0}}, Points{{0, 0, 1}, {0, 0, 2}}, Points(9, Vec3(0, 0, 0))}) {
    const Transfer transfer({{0, 0, 0}}, {{0, 0, 1}}, simulation, std::vector<char>(simulation.size(), 1), {});
    EXPECT_EQ(1, transfer.numDegenerate());
    Points now;
    Normals normals;
    transfer.apply(moved(simulation, [](const Vec3& p) { return Vec3(p + Vec3(1, 2, 3)); }), now, normals);
    EXPECT_LT((now[0] - Vec3(1, 2, 3)).norm(), 1e-9);
    EXPECT_EQ(Eigen::Vector3f(0, 0, 1), normals[0]);
  }
}

TEST(Transfer, LeavesPointsThatNothingMoves) {
  const Points dense = {{1, 2, 3}, {4, 5, 6}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Points now;
  Normals normals;
  Transfer(dense, Points(2, Vec3::UnitZ()), {}, {}, {}).apply({}, now, normals);
  EXPECT_EQ(dense, now);
  Transfer(dense, Points(2, Vec3::UnitZ()), {{0, 0, 0}}, {0}, {}).apply({{nan, nan, nan}}, now, normals);
  EXPECT_EQ(dense, now);
  EXPECT_EQ(Eigen::Vector3f(0, 0, 1), normals[1]);
  Transfer().apply({}, now);
  EXPECT_TRUE(now.empty());
}

TEST(Transfer, IgnoresUnusableSimulationPoints) {
  const Surface dense = makeSheet(20, 1), simulation = makeSheet(9, 2);
  std::vector<char> usable(simulation.positions.size(), 1);
  Points used, now_used, all = simulation.positions;
  for (std::size_t j = 0; j < all.size(); ++j) {
    usable[j] = j % 3 != 0;
    if (usable[j]) used.push_back(all[j]);
  }
  const auto bend = [](const Vec3& p) { return Vec3(p.x(), p.y(), p.x() * p.y()); };
  Points expected, now;
  Transfer(dense.positions, dense.normals, used, std::vector<char>(used.size(), 1), {}).apply(moved(used, bend), expected);
  const Transfer transfer(dense.positions, dense.normals, all, usable, {});
  Points positions = moved(all, bend);
  for (std::size_t j = 0; j < all.size(); j += 3) positions[j].setConstant(std::nan(""));
  transfer.apply(positions, now);
  EXPECT_EQ(expected, now);
}

TEST(Transfer, KeepsTheRestNormalWhereTangentsBecomeParallel) {
  const Surface dense = makeSheet(10, 1), simulation = makeSheet(6, 2);
  Points now;
  Normals normals;
  const Points flattened = moved(simulation.positions, [](const Vec3& p) { return Vec3(p.x(), 0, 0); });
  makeTransfer(dense, simulation).apply(flattened, now, normals);
  for (const auto& n : normals) EXPECT_EQ(Eigen::Vector3f(0, 0, 1), n);
}

TEST(Transfer, StaysFiniteOnSliversOutliersAndExtremeScales) {
  const std::vector<Points> clouds = {
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
      {{0, 0, 0}, {1e-9, 1, 0}, {0, 2, 0}, {-1e-9, 3, 0}, {0, 4, 0}, {1e-9, 5, 0}, {0, 6, 0}, {0, 7, 0}},
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1e20, 1e20, 1e20}},
      {{0, 0, 0}, {1e-25, 0, 0}, {0, 1e-25, 0}, {1e-25, 1e-25, 0}},
      {{1e6, 1e6, 1e6}, {1e6 + 1e-3, 1e6, 1e6}, {1e6, 1e6 + 1e-3, 1e6}, {1e6, 1e6, 1e6 + 1e-3}},
  };
  for (std::size_t c = 0; c < clouds.size(); ++c) {
    for (const Weighting weighting : {Weighting::kCompact, Weighting::kGaussian}) {
      TransferParams options;
      options.weighting = weighting;
      const Points& cloud = clouds[c];
      const Points tilted(cloud.size(), Vec3(0.6, 0.0, 0.8));
      const Transfer transfer(cloud, tilted, cloud, std::vector<char>(cloud.size(), 1), options);
      Points now;
      Normals normals;
      transfer.apply(moved(cloud, [](const Vec3& p) { return Vec3(kRotation * p); }), now, normals);
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        EXPECT_TRUE(now[i].allFinite()) << "cloud " << c;
        EXPECT_NEAR(1.0f, normals[i].norm(), 1e-5f) << "cloud " << c;
      }
    }
  }
}

TEST(Transfer, AllocatesNothingInTheSecondApply) {
  const Surface dense = makeWave(80, 1), simulation = makeWave(9, 2);
  const Transfer transfer = makeTransfer(dense, simulation);
  const Points positions = moved(simulation.positions, [](const Vec3& p) { return Vec3(kRotation * p); });
  Points now;
  Normals normals;
  std::vector<float> ratio;
  transfer.apply(positions, now, normals);
  transfer.areaRatio(positions, ratio);
  const long before = num_allocations;
  transfer.apply(positions, now, normals);
  transfer.apply(positions, now);
  transfer.areaRatio(positions, ratio);
  EXPECT_EQ(before, num_allocations);
}

TEST(Transfer, DoesNotDependOnTheNumberOfThreadsNorOnWantedNormals) {
  const Surface dense = makeWave(95, 1), simulation = makeWave(13, 2);
  const Points positions = moved(simulation.positions, [](const Vec3& p) { return Vec3(kRotation * p + p); });
  Points one, three, without_normals;
  Normals normals_one, normals_three;
  setNumThreads(1);
  makeTransfer(dense, simulation).apply(positions, one, normals_one);
  setNumThreads(3);
  makeTransfer(dense, simulation).apply(positions, three, normals_three);
  makeTransfer(dense, simulation).apply(positions, without_normals);
  setNumThreads(0);
  EXPECT_EQ(one, three);
  EXPECT_EQ(one, without_normals);
  EXPECT_EQ(normals_one, normals_three);
}

TEST(Transfer, PointsFollowWhatTheyAreToldTo) {
  // Two layers, each followed by its own points: motion of the other layer changes nothing.
  const Surface dense = makeSheet(20, 1), coarse = makeSheet(6, 2);
  Points both = coarse.positions;
  for (const Vec3& p : coarse.positions) both.push_back(p + Vec3(0.0, 0.0, 0.01));
  const std::vector<char> usable(both.size(), 1);
  const Index num_below = static_cast<Index>(coarse.positions.size());
  Lists followed;
  for (std::size_t i = 0; i < dense.positions.size(); ++i) {
    for (Index j = 0; j < 5; ++j) followed.items.push_back((static_cast<Index>(i) + 7 * j) % num_below);
    followed.offsets.push_back(static_cast<Index>(followed.items.size()));
  }
  const Transfer transfer(dense.positions, dense.normals, both, usable, {}, &followed);
  Points moved = both, now;
  for (std::size_t j = num_below; j < moved.size(); ++j) moved[j].z() += 1.0;
  transfer.apply(moved, now);
  // Displacements are kept as float, less their mean of a half.
  for (std::size_t i = 0; i < now.size(); ++i) EXPECT_LT((now[i] - dense.positions[i]).norm(), 1e-5);

  Lists too_few = followed, wrong = followed;
  too_few.offsets.pop_back();
  EXPECT_THROW(Transfer(dense.positions, dense.normals, both, usable, {}, &too_few), InputError);
  wrong.items[3] = static_cast<Index>(both.size());
  EXPECT_THROW(Transfer(dense.positions, dense.normals, both, usable, {}, &wrong), InputError);
}

TEST(Transfer, PointsThatAreGivenOthersToFollowDoAndTheRestStaysToTheBit) {
  const Surface dense = makeWave(20, 3), coarse = makeWave(6, 4);
  const std::vector<char> usable(coarse.positions.size(), 1);
  const TransferParams params;
  const Transfer whole(dense.positions, dense.normals, coarse.positions, usable, params);
  Points moved = coarse.positions;
  for (std::size_t j = 0; j < moved.size(); ++j) moved[j] += Vec3(0.01 * j, 0.02, -0.01 * (j % 5));
  Points expected, found;
  whole.apply(moved, expected);

  // Points that are followed already change nothing.
  Transfer same = whole;
  Lists as_before;
  const std::vector<Index> some = {3, 4, 17, 200};
  for (Index d : some) {
    const std::vector<Index> sources = whole.sourcesOf(d);
    EXPECT_EQ(static_cast<Index>(sources.size()), params.k);
    as_before.items.insert(as_before.items.end(), sources.begin(), sources.end());
    as_before.offsets.push_back(static_cast<Index>(as_before.items.size()));
  }
  same.refit(some, as_before, dense.normals, params);
  same.apply(moved, found);
  EXPECT_EQ(found, expected);

  // A single moved point carries a following point along.
  Transfer other = whole;
  Lists single;
  single.items = {7};
  single.offsets.push_back(1);
  other.refit({17}, single, dense.normals, params);
  EXPECT_EQ(other.sourcesOf(17), std::vector<Index>{7});
  other.apply(moved, found);
  EXPECT_LT((found[17] - dense.positions[17] - (moved[7] - coarse.positions[7])).norm(), 1e-6);
  for (std::size_t d = 0; d < found.size(); ++d)
    if (d != 17) {
      EXPECT_EQ(found[d], expected[d]);
    }
}

// Dense points row by row, so that a tile of dense points follows few simulation points.
struct Strip {
  Surface dense = makeWave(100, 1), simulation = makeWave(25, 2);
  Transfer transfer = makeTransfer(dense, simulation);
  Transfer::Frame frame;
  Points now;
  Normals normals;

  Index update(const Points& positions, bool with_normals = true) {
    return transfer.update(positions, frame, now, with_normals ? &normals : nullptr, [](Index, Index) {});
  }
  void expectWhole(const Points& positions) const {
    Points whole;
    Normals whole_normals;
    transfer.apply(positions, whole, whole_normals);
    EXPECT_EQ(now, whole);
    EXPECT_EQ(normals, whole_normals);
  }
};

TEST(TransferTiles, OneMovedPointMakesTheTilesThatFollowItAloneToTheBit) {
  Strip strip;
  Points positions =
      moved(strip.simulation.positions, [](const Vec3& p) { return Vec3(p + Vec3(0.1 * p.y(), 0.0, 0.05 * p.x() * p.x())); });
  EXPECT_EQ(strip.update(positions), strip.transfer.numTiles());
  strip.expectWhole(positions);
  EXPECT_EQ(strip.update(positions), 0);
  strip.expectWhole(positions);
  positions[300].z() += 0.003;
  const Index made = strip.update(positions);
  EXPECT_GT(made, 0);
  EXPECT_LT(made, strip.transfer.numTiles() / 2);
  strip.expectWhole(positions);
}

TEST(TransferTiles, EverythingIsMadeWhenEverythingMovesOrSomethingElseIsWanted) {
  Strip strip;
  const Index all = strip.transfer.numTiles();
  Points positions = moved(strip.simulation.positions, [](const Vec3& p) { return Vec3(kRotation * p); });
  EXPECT_EQ(strip.update(positions, false), all);
  EXPECT_EQ(strip.update(positions), all);  // now with normals
  strip.expectWhole(positions);
  for (Vec3& p : positions) p += Vec3(0.3, 0.0, 0.0);
  EXPECT_EQ(strip.update(positions), all);
  strip.expectWhole(positions);
  strip.frame.forget();
  EXPECT_EQ(strip.update(positions), all);
  // In its last state, a frame without normals has none.
  EXPECT_EQ(strip.update(positions, false), 0);
  EXPECT_EQ(strip.update(positions), all);
}

TEST(TransferTiles, WhatIsCalledAfterEachTileSeesEachPointOnceForAnyNumberOfThreads) {
  Strip strip;
  const Points positions = moved(strip.simulation.positions, [](const Vec3& p) { return Vec3(kRotation * p); });
  for (const int threads : {1, 2, 3}) {
    setNumThreads(threads);
    std::vector<int> seen(strip.dense.positions.size(), 0);
    strip.frame.forget();
    strip.transfer.update(positions, strip.frame, strip.now, &strip.normals, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) ++seen[i];
    });
    EXPECT_EQ(seen, std::vector<int>(seen.size(), 1));
    strip.expectWhole(positions);
  }
  setNumThreads(0);
}

TEST(TransferTiles, AllocateNothingInTheSecondUpdate) {
  Strip strip;
  Points positions = strip.simulation.positions;
  const std::function<void(Index, Index)> nothing = [](Index, Index) {};
  strip.transfer.update(positions, strip.frame, strip.now, &strip.normals, nothing);
  positions[300].z() += 0.003;
  const long before = num_allocations;
  strip.transfer.update(positions, strip.frame, strip.now, &strip.normals, nothing);
  EXPECT_EQ(before, num_allocations);
}

TEST(TransferTiles, PointsThatAreGivenOthersToFollowAreMadeWithThese) {
  Strip strip;
  Points positions = strip.simulation.positions;
  Lists single;
  single.items = {600};
  single.offsets.push_back(1);
  strip.transfer.refit({17}, single, strip.dense.normals, {});
  strip.update(positions);
  positions[600].z() += 0.25;
  EXPECT_GT(strip.update(positions), 0);
  EXPECT_NEAR(strip.now[17].z() - strip.dense.positions[17].z(), 0.25, 1e-6);
  strip.expectWhole(positions);
}

TEST(Transfer, RefusesWhatItCannotUse) {
  const Surface dense = makeSheet(4, 1), simulation = makeSheet(3, 2);
  const std::vector<char> usable(9, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Transfer(dense.positions, {}, simulation.positions, usable, {}), InputError);
  EXPECT_THROW(Transfer(dense.positions, dense.normals, simulation.positions, {}, {}), InputError);
  EXPECT_THROW(Transfer(dense.positions, Points(16, Vec3::Zero()), simulation.positions, usable, {}), InputError);
  EXPECT_THROW(Transfer(Points(16, Vec3(0, nan, 0)), dense.normals, simulation.positions, usable, {}), InputError);
  EXPECT_THROW(Transfer(dense.positions, dense.normals, Points(9, Vec3(nan, 0, 0)), usable, {}), InputError);
  for (const Index k : {0, -1, 65}) {
    TransferParams options;
    options.k = k;
    EXPECT_THROW(makeTransfer(dense, simulation, options), InputError);
  }
  for (const double width : {-1.0, nan}) {
    TransferParams options;
    options.gaussian_width = width;
    EXPECT_THROW(makeTransfer(dense, simulation, options), InputError);
  }
  Points now;
  EXPECT_THROW(makeTransfer(dense, simulation).apply(Points(8), now), InputError);
}

}  // namespace
}  // namespace deformable_surface::transfer
