// Single points are where the transfer of all points puts them, and the forces that they pass on do the same work.
#include "deformable_surface/transfer/sampled_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_surface::transfer {
namespace {

// A wavy cloud, every seventh point of which is simulated; the others are samples of the cell of the nearest one.
struct Wave {
  Points dense, normals, simulation;
  std::vector<Index> cell;

  Wave() {
    const auto height = [](double x, double y) { return 0.08 * std::sin(5.0 * x) * std::cos(4.0 * y); };
    std::mt19937 random(4);
    std::uniform_real_distribution<double> u(-0.01, 0.01);
    Points all, all_normals;
    for (int i = 0; i < 24; ++i)
      for (int j = 0; j < 24; ++j) {
        const double x = i / 24.0 + u(random), y = j / 24.0 + u(random), e = 1e-5;
        all.emplace_back(x, y, height(x, y));
        all_normals.push_back(
            Vec3((height(x - e, y) - height(x + e, y)) / (2 * e), (height(x, y - e) - height(x, y + e)) / (2 * e), 1.0)
                .normalized());
      }
    for (std::size_t d = 0; d < all.size(); d += 7) simulation.push_back(all[d]);
    std::vector<std::pair<Index, std::size_t>> order;
    for (std::size_t d = 0; d < all.size(); ++d) {
      Index nearest = 0;
      for (std::size_t i = 0; i < simulation.size(); ++i)
        if ((simulation[i] - all[d]).norm() < (simulation[nearest] - all[d]).norm()) nearest = static_cast<Index>(i);
      if (d % 7 != 0) order.emplace_back(nearest, d);
    }
    std::sort(order.begin(), order.end());
    for (const auto& [owner, d] : order) {
      dense.push_back(all[d]);
      normals.push_back(all_normals[d]);
      cell.push_back(owner);
    }
  }
  Transfer transfer() const {
    return Transfer(dense, normals, simulation, std::vector<char>(simulation.size(), 1), TransferParams());
  }
  /// Bent and stretched.
  Points bend(double angle) const {
    Points now;
    for (const Vec3& p : simulation)
      now.emplace_back(std::sin(angle * p.x()) / angle - p.z() * std::sin(angle * p.x()), 1.1 * p.y(),
                       (1.0 - std::cos(angle * p.x())) / angle + p.z() * std::cos(angle * p.x()));
    return now;
  }
};

TEST(SampledPoints, AreWhereTheTransferPutsThem) {
  const Wave wave;
  const Transfer transfer = wave.transfer();
  const SampledPoints samples(transfer, wave.simulation, wave.cell);
  ASSERT_EQ(samples.size(), static_cast<Index>(wave.dense.size()));
  for (const Points& now : {wave.simulation, wave.bend(1.0), wave.bend(2.5)}) {
    Points expected;
    transfer.apply(now, expected);
    for (Index s = 0; s < samples.size(); ++s) EXPECT_LT((samples.place(s, now) - expected[s]).norm(), 2e-5) << s;
  }
}

// F . dp = sum_j F_j . dx_j for any motion, heights over the fitted planes included.
TEST(SampledPoints, PassForcesOnWithTheWorkThatTheyDo) {
  const Wave wave;
  const SampledPoints samples(wave.transfer(), wave.simulation, wave.cell);
  const Points now = wave.bend(2.0);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  double largest_height = 0.0;
  for (Index s = 0; s < samples.size(); s += 5) {
    const Vec3 force(u(random), u(random), u(random));
    Points forces(now.size(), Vec3::Zero()), ahead = now, behind = now;
    samples.scatter(s, now, force, forces);
    double work = 0.0;
    constexpr double kStep = 1e-6;
    for (std::size_t j = 0; j < now.size(); ++j) {
      const Vec3 way(u(random), u(random), u(random));
      ahead[j] += kStep * way;
      behind[j] -= kStep * way;
      work += forces[j].dot(way);
    }
    EXPECT_NEAR(force.dot(samples.place(s, ahead) - samples.place(s, behind)) / (2.0 * kStep), work, 1e-7) << s;
    largest_height = std::max(largest_height, samples.height(samples.cellOf(s)));
  }
  EXPECT_GT(largest_height, 1e-3);  // there are some
}

TEST(SampledPoints, TheReachOfACellHoldsItsSamplesWhenItIsStretched) {
  const Wave wave;
  const SampledPoints samples(wave.transfer(), wave.simulation, wave.cell);
  Points now = wave.simulation;
  for (Vec3& p : now) p *= 2.5;
  for (Index s = 0; s < samples.size(); ++s) {
    const Index cell = samples.cellOf(s);
    EXPECT_LE((samples.place(s, now) - now[cell]).norm(), 1.01 * samples.findReach(cell, now));
  }
}

TEST(SampledPoints, APartHasThoseOfWhichAllSourcesAreLeft) {
  const Wave wave;
  const SampledPoints samples(wave.transfer(), wave.simulation, wave.cell);
  // The half with x < 0.5, in the opposite order.
  std::vector<Index> new_index(wave.simulation.size(), -1);
  Points part_now;
  Index kept = 0;
  const Points now = wave.bend(1.5);
  for (std::size_t i = wave.simulation.size(); i-- > 0;) {
    if (wave.simulation[i].x() >= 0.5) continue;
    new_index[i] = kept++;
    part_now.push_back(now[i]);
  }
  std::vector<Index> old;
  const SampledPoints part = samples.takePart(new_index, kept, old);
  ASSERT_EQ(part.size(), static_cast<Index>(old.size()));
  ASSERT_GT(part.size(), samples.size() / 4);
  ASSERT_LT(part.size(), samples.size() / 2);
  for (Index s = 0; s < part.size(); ++s) {
    EXPECT_EQ(part.place(s, part_now), samples.place(old[s], now));
    EXPECT_EQ(part.cellOf(s), new_index[samples.cellOf(old[s])]);
    EXPECT_TRUE(s == 0 || part.cellOf(s - 1) <= part.cellOf(s));
    EXPECT_TRUE(part.begin(part.cellOf(s)) <= s && s < part.end(part.cellOf(s)));
  }
}

// Of a square of two triangles, in opposite order of cells.
const Points kSquare{Vec3(0.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0), Vec3(1.0, 1.0, 0.0), Vec3(0.0, 1.0, 0.0)};
const std::vector<PlaceOnTriangle> kPlaces{
    {{0, 2, 3}, {0.2, 0.2, 0.6}}, {{0, 1, 2}, {0.25, 0.0, 0.75}}, {{0, 1, 2}, {0.5, 0.5, 0.0}}};

TEST(SampledPoints, OnTrianglesLieInTheCellOfTheNearestCornerAndFollowTheCorners) {
  const SampledPoints samples(kPlaces, kSquare);
  ASSERT_EQ(samples.size(), 3);
  for (const Index s : {0, 1, 2}) EXPECT_TRUE(samples.isSpare(s) && samples.isPlace(s));
  Points now = kSquare;
  now[2].z() = 1.0;
  const std::pair<Index, Vec3> expected[] = {{0, Vec3(0.5, 0.0, 0.0)}, {2, Vec3(0.75, 0.75, 0.75)}, {3, Vec3(0.2, 0.8, 0.2)}};
  for (Index s = 0; s < 3; ++s) {
    EXPECT_EQ(samples.cellOf(s), expected[s].first);
    EXPECT_LT((samples.place(s, now) - expected[s].second).norm(), 1e-15);
    EXPECT_LT((samples.findVelocity(s, now) - expected[s].second).norm(), 1e-15);
    EXPECT_LE((samples.place(s, kSquare) - kSquare[samples.cellOf(s)]).norm(), samples.extent(samples.cellOf(s)));
  }
  EXPECT_EQ(samples.begin(1), samples.end(1));
  EXPECT_EQ(samples.beginSpare(2), 1);
}

TEST(SampledPoints, OnTrianglesPassForcesOnByTheirWeights) {
  const SampledPoints samples(kPlaces, kSquare);
  Points forces(4, Vec3::Zero());
  samples.scatter(1, kSquare, Vec3(0.0, 0.0, 8.0), forces);
  EXPECT_EQ(forces, (Points{Vec3(0.0, 0.0, 2.0), Vec3::Zero(), Vec3(0.0, 0.0, 6.0), Vec3::Zero()}));
}

TEST(SampledPoints, APartOfThoseOnTrianglesHasTheSamePlaces) {
  const SampledPoints samples(kPlaces, kSquare);
  std::vector<Index> old;
  const SampledPoints part = samples.takePart({2, -1, 1, 0}, 3, old);
  ASSERT_EQ(old, std::vector<Index>{2});
  EXPECT_TRUE(part.isPlace(0));
  EXPECT_LT((part.place(0, {kSquare[3], kSquare[2], kSquare[0]}) - Vec3(0.2, 0.8, 0.0)).norm(), 1e-15);
}

}  // namespace
}  // namespace deformable_surface::transfer
