#include "deformable_surface/simulation/contact_points.h"
#include "../../src/simulation/points_between.h"
#include "clouds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace deformable_surface::test {
namespace {

struct Sheet {
  simulation::RestSurface rest;
  std::vector<double> masses;
  simulation::ContactPoints points{masses};

  Sheet() {
    simulation::SceneParams p = hangingSheet();
    rest = simulation::buildRestSurface(p, sheetCloud(40));
    masses = rest.model->masses();
    points.setBetween(simulation::choosePointsBetween(p, rest.dense, rest, true));
  }
};

TEST(ContactPoints, ASimulationPointIsItselfAndAPointBetweenBelongsToItsCell) {
  const Sheet sheet;
  const Index n = sheet.points.numSimulated();
  ASSERT_GT(sheet.points.size(), 3 * n);
  EXPECT_EQ(sheet.points.simulationPointOf(5), 5);
  EXPECT_EQ(sheet.points.place(5, sheet.rest.points), sheet.rest.points[5]);
  for (Index p = n; p < sheet.points.size(); ++p) {
    const Vec3 place = sheet.points.place(p, sheet.rest.points);
    const Index cell = sheet.points.simulationPointOf(p);
    EXPECT_EQ(sheet.points.massOf(p), sheet.masses[cell]);
    EXPECT_LT((place - sheet.rest.points[cell]).norm(), 0.12);
  }
}

// As where a mesh has a thin cell: springs and damping by the masses of the cells would need many times the sub-steps.
TEST(ContactPoints, SpringsAndDampingAreWeakWherePointsBetweenFollowALightOne) {
  Sheet sheet;
  const Index n = sheet.points.numSimulated();
  const double even_share = sheet.points.dampedShare();
  sheet.masses[n / 2] *= 1e-3;
  sheet.points.followMasses();
  Index num_weak = 0;
  for (Index p = n; p < sheet.points.size(); ++p) {
    const double of_cell = sheet.masses[sheet.points.simulationPointOf(p)];
    EXPECT_LE(sheet.points.massOf(p), 2.0 * (1.0 + 1e-9) * sheet.points.ownMassOf(p));
    num_weak += sheet.points.massOf(p) < 0.05 * of_cell;
  }
  EXPECT_GT(num_weak, 8);
  EXPECT_LT(sheet.points.dampedShare(), 4.0 * even_share);
}

// The stiffness matrix of a point is w_i w_j K. Its effect on a motion is that of the point's own motion.
TEST(ContactPoints, StiffnessActsThroughTheWeightsAndItsRowBoundHolds) {
  const Sheet sheet;
  const Index n = sheet.points.numSimulated(), p = n + 40;
  BlockSparse stiffness;
  stiffness.begin(n);
  sheet.points.addStiffness(p, 3.0 * Mat3::Identity(), stiffness);
  stiffness.finish();
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Points motion;
  for (Index i = 0; i < n; ++i) motion.emplace_back(u(random), u(random), u(random));
  const Eigen::VectorXd flat = Eigen::Map<const Eigen::VectorXd>(motion.data()->data(), 3 * n);
  Eigen::VectorXd product(3 * n);
  stiffness.multiply(flat, product);
  Points expected(n, Vec3::Zero());
  sheet.points.addForce(p, sheet.rest.points, 3.0 * sheet.points.findVelocity(p, motion), expected);
  std::vector<double> bound(n, 0.0);
  sheet.points.addRowBound(p, 3.0, bound);
  double sum = 0.0;
  for (Index i = 0; i < n; ++i) {
    EXPECT_LT((product.segment<3>(3 * i) - expected[i]).norm(), 1e-12);
    EXPECT_LE(expected[i].lpNorm<Eigen::Infinity>(), bound[i] + 1e-12);
    sum += bound[i];
  }
  EXPECT_GT(sum, 2.9);
}

// Damping of all points in one direction, over that of the simulation points by their masses: below the share for any motion, and
// nearly as large for some.
TEST(ContactPoints, TheDampedShareBoundsAllMotions) {
  const Sheet sheet;
  const Index n = sheet.points.numSimulated();
  const double share = sheet.points.dampedShare();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Points motion;
  for (Index i = 0; i < n; ++i) motion.emplace_back(u(random), 0.0, 0.0);
  double ratio = 0.0;
  for (int k = 0; k < 200; ++k) {
    double damped = 0.0, whole = 0.0;
    Points forces(n, Vec3::Zero());
    for (Index p = 0; p < sheet.points.size(); ++p) {
      const Vec3 along(sheet.points.findVelocity(p, motion).x(), 0.0, 0.0);
      damped += sheet.points.dampedMassOf(p) * along.squaredNorm();
      if (sheet.points.isBetween(p))
        sheet.points.between()->visitWeights(p - n,
                                             [&](Index i, double w) { forces[i] += w * sheet.points.dampedMassOf(p) * along; });
      else
        forces[p] += sheet.points.dampedMassOf(p) * along;
    }
    for (Index i = 0; i < n; ++i) whole += sheet.masses[i] * motion[i].squaredNorm();
    ratio = damped / whole;
    ASSERT_LE(ratio, share * (1.0 + 1e-9));
    for (Index i = 0; i < n; ++i) motion[i] = forces[i] / (sheet.masses[i] * std::sqrt(whole));
  }
  EXPECT_GT(ratio, 0.95 * share);
  EXPECT_LT(share, 1.9);
}

TEST(ContactPoints, APointIsHeldOnlyIfAllThatItFollowsIs) {
  const Sheet sheet;
  const Index n = sheet.points.numSimulated(), p = n + 7;
  std::vector<char> held(n, 1);
  EXPECT_TRUE(sheet.points.isHeld(p, held));
  sheet.points.between()->visitWeights(7, [&](Index j, double) { held[j] = 0; });
  held[sheet.points.simulationPointOf(p)] = 1;
  EXPECT_FALSE(sheet.points.isHeld(p, held));
}

TEST(ContactPoints, APartNumbersItsPointsBothWays) {
  const Sheet sheet;
  const Index n = sheet.points.numSimulated();
  std::vector<Index> new_index(n, -1);
  std::vector<double> masses;
  for (Index i = 0; i < n; ++i) {
    if (sheet.rest.points[i].x() > 0.6) continue;
    new_index[i] = static_cast<Index>(masses.size());
    masses.push_back(sheet.masses[i]);
  }
  simulation::ContactPoints part(masses);
  part.takePart(sheet.points, new_index);
  ASSERT_GT(part.size(), 3 * part.numSimulated());
  for (Index p = 0; p < part.size(); ++p) {
    const Index there = part.numberInWhole()[p];
    EXPECT_EQ(part.numberInPart()[there], p);
    EXPECT_EQ(part.dampedMassOf(p), sheet.points.dampedMassOf(there));
  }
}

}  // namespace
}  // namespace deformable_surface::test
