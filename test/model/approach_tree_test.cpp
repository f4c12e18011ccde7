// The tree that tells whether lists still hold, against a look at all pairs.
#include "deformable_surface/model/oriented_particles/approach_tree.h"
#include "deformable_surface/base/parallel.h"
#include "model_checks.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using model::ApproachTree;

constexpr ApproachTree::Lengths kLengths{0.1, 0.13, 0.03, true};

bool allHold(const Points& then, const Points& now, const ApproachTree::Lengths& lengths) {
  for (std::size_t i = 0; i < now.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (!((now[j] - now[i]).norm() < lengths.radius)) continue;
      const Vec3 before = then[j] - then[i];
      if (lengths.is_listed_by_distance && before.norm() <= lengths.reach) continue;
      if ((now[j] - now[i] - before).norm() > lengths.skin) return false;
    }
  return true;
}

bool allListed(const Points& then, const Points& now, const ApproachTree::Lengths& lengths) {
  for (std::size_t i = 0; i < now.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if ((now[j] - now[i]).norm() < lengths.radius && !((then[j] - then[i]).norm() <= lengths.reach)) return false;
  return true;
}

Points randomPoints(Index n, double size, std::mt19937& generator) {
  Points points(n);
  for (Vec3& p : points) p = size * randomVector(generator);
  return points;
}

TEST(ApproachTree, TellsWhatALookAtAllPairsTells) {
  std::mt19937 generator(3);
  int held = 0, broken = 0;
  for (const Index n : {1, 2, 7, 8, 9, 16, 17, 100, 777})
    for (int trial = 0; trial < 60; ++trial) {
      const Points then = randomPoints(n, 0.03 * std::sqrt(static_cast<double>(n)), generator);
      Points now = then;
      // Waves, a part that leaves, and one particle that strays.
      const double amount = 0.02 * trial / 60.0;
      const Vec3 wave = 20.0 * randomVector(generator), by = 0.2 * randomVector(generator);
      for (Index i = 0; i < n; ++i)
        now[i] += amount * std::sin(wave.dot(then[i])) * Vec3::UnitZ() + 0.1 * amount * randomVector(generator);
      if (trial % 3 == 1)
        for (Vec3& p : now) p += p.x() > 0.0 ? by : Vec3::Zero();
      if (trial % 3 == 2) now[n / 2] += by;
      for (const bool by_distance : {true, false}) {
        ApproachTree::Lengths lengths = kLengths;
        lengths.is_listed_by_distance = by_distance;
        ApproachTree tree;
        tree.renew(trial % 2 == 0 ? then : randomPoints(n, 1.0, generator));  // or of other places
        const bool expected = allHold(then, now, lengths);
        // It may give up, but never overlooks a pair.
        const bool found = tree.holds(then, now, lengths), may_differ = trial % 2 != 0 || n < 20;
        EXPECT_TRUE(found == expected || (may_differ && !found)) << n << " " << trial;
        ++(expected ? held : broken);
      }
    }
  EXPECT_GT(held, 100);
  EXPECT_GT(broken, 100);
}

TEST(ApproachTree, GivesUpWhenItHasTakenAsLongAsMakingTheListsAnew) {
  std::mt19937 generator(5);
  Points then = randomPoints(2000, 1.0, generator);
  Points now = then;
  for (Vec3& p : now) p += 0.02 * randomVector(generator);  // within reach, but not within the skin of each other
  // Two that were not in reach and nearly are: displacements cannot count from here.
  for (const double x : {50.0, 100.0}) then.push_back(Vec3(x, 0.0, 0.0));
  for (const double x : {50.0, 50.1004}) now.push_back(Vec3(x, 0.0, 0.0));
  ApproachTree tree;
  tree.renew(then);
  const ApproachTree::Lengths lengths{0.1, 10.0, 0.001, true};
  int times = 0;
  while (times < 1000 && tree.holds(then, now, lengths)) ++times;
  EXPECT_LT(times, 1000);
  tree.renew(then);
  EXPECT_TRUE(tree.holds(then, then, lengths));
}

// A surface that turns moves far, and no pair approaches.
TEST(ApproachTree, HoldsThroughATurnAndStillSeesWhatComesNear) {
  for (const bool by_distance : {true, false}) {
    ApproachTree::Lengths lengths = kLengths;
    lengths.is_listed_by_distance = by_distance;
    Points then;
    for (Index i = 0; i < 40; ++i)
      for (Index j = 0; j < 40; ++j) then.push_back(Vec3(0.05 * i, 0.05 * j, 0.0));
    ApproachTree tree;
    tree.renew(then);
    Points now = then;
    int held = 0, based = 0;
    for (int k = 1; k <= 400; ++k) {
      const Eigen::AngleAxisd turn(0.01 * k, Vec3(1.0, 2.0, 3.0).normalized());
      for (std::size_t i = 0; i < now.size(); ++i) now[i] = turn * then[i];
      held += tree.holds(then, now, lengths);
      based += tree.base() != nullptr;
    }
    // Without lists by distance a pair counts as out of reach once it has moved, also if it has only turned.
    EXPECT_EQ(held == 400, by_distance);
    if (by_distance) EXPECT_GT(based, 300);
    const Vec3 first = now[0];
    now[0] = now[1599] + Vec3(0.0, 0.0, 0.099);
    EXPECT_FALSE(tree.holds(then, now, lengths));
    now[0] = first;
    EXPECT_EQ(tree.holds(then, now, lengths), by_distance);
  }
}

// Particles that wander: whenever it holds, a look at all pairs finds none that is near and was not.
TEST(ApproachTree, NeverOverlooksAPairHoweverOftenDisplacementsCountFromElsewhere) {
  std::mt19937 generator(8);
  int based = 0, held = 0;
  for (int run = 0; run < 20; ++run) {
    const Index n = 300;
    const Points then = randomPoints(n, 0.4, generator);
    Points now = then;
    ApproachTree tree;
    tree.renew(then);
    const Vec3 axis = randomVector(generator).normalized();
    const double noise = 0.0002 * run;
    for (int k = 0; k < 60; ++k) {
      const Eigen::AngleAxisd turn(0.05, axis);
      for (Vec3& p : now) p = turn * p + noise * randomVector(generator);
      const bool holds = tree.holds(then, now, kLengths);
      if (holds) EXPECT_TRUE(allListed(then, now, kLengths)) << run << " " << k;
      held += holds;
      based += tree.base() != nullptr;
    }
  }
  EXPECT_GT(held, 100);
  EXPECT_GT(based, 100);
}

TEST(ApproachTree, ItsMemoryCounts) {
  std::mt19937 generator(5);
  ApproachTree tree;
  EXPECT_EQ(tree.bytes(), 0u);
  tree.renew(randomPoints(1000, 1.0, generator));
  EXPECT_EQ(tree.size(), 1000);
  EXPECT_GT(tree.bytes(), 1000 * 3 * sizeof(double));
}

}  // namespace
}  // namespace deformable_surface::test
