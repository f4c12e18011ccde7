// The reference solutions against published digits, and the fit of the order.
#include "physics/references.h"
#include "series.h"

#include <cmath>

namespace deformable_surface::physics {
namespace {

TEST(References, TheHeavyElasticaAgreesWithCollocation) {
  // Chebyshev collocation of the same equation, six digits.
  const double rows[][3] = {{0.1, 0.012498, 0.999911},
                            {1.0, 0.123471, 0.991246},
                            {10.0, 0.700200, 0.656354},
                            {100.0, 0.937524, 0.159223},
                            {1000.0, 0.981141, 0.045986}};
  for (const auto& row : rows) {
    EXPECT_NEAR(solveElastica(row[0], 0.0).droop, row[1], 1e-6) << row[0];
    EXPECT_NEAR(solveElastica(row[0], 0.0).reach, row[2], 1e-6) << row[0];
  }
}

TEST(References, TheElasticaUnderAnEndForceAgreesWithTheTableOfSze) {
  // [sze2004, 3.1]: P / Pmax, -u, w for L = 10 and Pmax L^2 / D = 4. Shell elements: 0.1 % from the inextensible strip.
  const double rows[][3] = {{0.25, 0.563, 3.015}, {0.5, 1.604, 4.933}, {1.0, 3.286, 6.698}};
  for (const auto& row : rows) {
    const ElasticaTip tip = solveElastica(0.0, 4.0 * row[0]);
    EXPECT_NEAR(10.0 * (1.0 - tip.reach), row[1], 0.005) << row[0];
    EXPECT_NEAR(10.0 * tip.droop, row[2], 0.005) << row[0];
  }
}

TEST(References, HenckysMembraneAgreesWithItsTable) {
  EXPECT_NEAR(solveHencky(0.0), 0.718319, 1e-6);
  EXPECT_NEAR(solveHencky(0.3), 0.653443, 1e-6);
  EXPECT_NEAR(solveHencky(1.0 / 3.0), 0.644776, 1e-6);
}

TEST(References, AStiffCableHangsAsACatenary) {
  // L / S = 1.2: sag / S = 0.29234380.
  const ElasticCable cable{1e9, 3.0, 1.2};
  EXPECT_NEAR(cable.z(0.6, cable.solveTension(1.0)), 0.29234380, 1e-6);
}

TEST(References, ACantileverStartsAtRestAndSwingsAboutItsSag) {
  EXPECT_DOUBLE_EQ(sagCantilever(1.0, kAtRest), 1.0 / 8.0);
  for (const double s : {0.25, 0.5, 1.0}) EXPECT_NEAR(sagCantilever(s, 0.0), 0.0, 1e-6);
  // Half a period of the first mode, which is nearly all of the motion of the end.
  const double half_period = std::acos(-1.0) / (1.8751040687 * 1.8751040687);
  EXPECT_NEAR(sagCantilever(1.0, half_period), 2.0 / 8.0, 0.01);
}

TEST(References, TheClampedPlateAgreesWithItsTable) {
  // [timoshenko1959, table 35] and, to more digits, Taylor and Govindjee 2004: 0.00126532.
  const ClampedPlate sag;
  EXPECT_NEAR(sag(0.5, 0.5), 0.00126532, 1e-8);
  EXPECT_NEAR(sag(0.3, 0.8), sag(0.8, 0.7), 1e-12);
  EXPECT_EQ(sag(1.1, 0.5), 0.0);
}

TEST(References, APressedRingBucklesTouchesAndFlattensAtThePublishedPressures) {
  // Buckling at 3, first contact at 5.247, contact along a line at 10.34 [flaherty1972].
  EXPECT_NEAR(findRingPressure(0.95), 3.006009, 1e-6);
  EXPECT_NEAR(findRingPressure(0.2), 4.306165, 1e-6);
  EXPECT_NEAR(findRingPressure(1e-9), 5.246887, 1e-6);
  const FlatRing touching = solveRing(6.296069, 0.0), flat = solveRing(10.336033, 0.0);
  EXPECT_NEAR(touching.force, 1.63386, 1e-5);
  EXPECT_NEAR(touching.half_width, 1.376808, 1e-6);
  EXPECT_NEAR(flat.flattest, 0.0, 1e-6);
  EXPECT_NEAR(flat.force, 7.94970, 1e-5);
  EXPECT_NEAR((flat.quarter.back() - Vec2(0.0, 0.0)).norm(), 0.0, 1e-6);
}

TEST(OrderOfConvergence, IsTheSlopeAndItsSpreadTheScatter) {
  const auto make = [](double size, double error) {
    Answer a;
    a.size = size;
    a.error = error;
    return a;
  };
  const Order clean = fitOrder({make(0.4, 0.16), make(0.2, 0.04), make(0.1, 0.01)});
  EXPECT_NEAR(clean.value, 2.0, 1e-12);
  EXPECT_NEAR(clean.spread, 0.0, 1e-7);
  EXPECT_GT(fitOrder({make(0.4, 0.16), make(0.2, 0.08), make(0.1, 0.01)}).spread, 0.1);
}

}  // namespace
}  // namespace deformable_surface::physics
