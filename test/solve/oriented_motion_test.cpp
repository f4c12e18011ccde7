// The loops that move points with orientation, against the exponential by sine and cosine.
#include "../../src/solve/oriented_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace deformable_surface::test {
namespace {

using solve::turnPoints;

Vec3 drawVector(std::mt19937& generator) {
  std::normal_distribution<double> normal;
  const double x = normal(generator), y = normal(generator);
  return {x, y, normal(generator)};
}

struct Turning {
  Points spins;
  Orientations orientations;
};

// Angles from nothing to several turns in a second.
Turning draw(Index n) {
  std::mt19937 generator(3);
  Turning drawn;
  for (Index i = 0; i < n; ++i) {
    drawn.spins.push_back(std::pow(10.0, -6.0 + 7.0 * i / n) * drawVector(generator));
    const Vec3 v = drawVector(generator);
    drawn.orientations.push_back(Quaternion(0.3, v.x(), v.y(), v.z()).normalized());
  }
  return drawn;
}

TEST(OrientedMotion, TurnsByTheExactExponentialAndKeepsLengths) {
  Turning given = draw(203);
  const Orientations before = given.orientations;
  turnPoints(0, 203, 1.0, given.spins, nullptr, given.orientations);
  for (Index i = 0; i < 203; ++i) {
    const double angle = given.spins[i].norm();
    const Quaternion exact = Quaternion(Eigen::AngleAxisd(angle, given.spins[i] / angle)) * before[i];
    EXPECT_LT((given.orientations[i].coeffs() - exact.coeffs()).norm(), 2e-15) << angle;
    EXPECT_NEAR(given.orientations[i].norm(), 1.0, 1e-15) << angle;
  }
}

TEST(OrientedMotion, LengthsStayOneInManySmallTurns) {
  Turning given = draw(40);
  for (int k = 0; k < 100000; ++k) turnPoints(0, 40, 0.01, given.spins, nullptr, given.orientations);
  for (const Quaternion& q : given.orientations) EXPECT_NEAR(q.norm(), 1.0, 1e-15);
}

// Parts of a surface number their points otherwise, and blocks end anywhere.
TEST(OrientedMotion, TheBitsOfAPointDoNotDependOnThoseBesideIt) {
  Turning together = draw(203), alone = together;
  turnPoints(0, 203, 1.0, together.spins, nullptr, together.orientations);
  for (Index i = 0; i < 203; ++i) turnPoints(i, i + 1, 1.0, alone.spins, nullptr, alone.orientations);
  for (Index i = 0; i < 203; ++i) EXPECT_EQ(together.orientations[i].coeffs(), alone.orientations[i].coeffs()) << i;
}

TEST(OrientedMotion, HeldTurnsStayAndTheOthersDoAsWithoutThem) {
  Turning free = draw(50), some = free;
  const Orientations before = free.orientations;
  std::vector<char> held(50, 0);
  for (Index i = 0; i < 50; i += 3) held[i] = 1;
  turnPoints(0, 50, 1.0, free.spins, nullptr, free.orientations);
  turnPoints(0, 50, 1.0, some.spins, held.data(), some.orientations);
  for (Index i = 0; i < 50; ++i)
    EXPECT_EQ(some.orientations[i].coeffs(), (held[i] ? before : free.orientations)[i].coeffs()) << i;
}

}  // namespace
}  // namespace deformable_surface::test
