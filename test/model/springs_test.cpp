// One spring whose forces, energy and stiffness are known, and what happens where its ends meet.
#include "deformable_surface/model/mass_spring/springs.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

constexpr double kStiffness = 50.0, kLength = 2.0, kBeta = 0.125;

struct OneSpring {
  Points forces(bool elastic, double beta) const {
    PaddedPoints positions;
    positions.assign(state.positions);
    Points forces(2, Vec3::Zero());
    springs.addForces(state, positions, elastic, beta, forces);
    return forces;
  }

  model::Springs springs{{{0, 1}}, {Vec3::Zero(), Vec3(kLength, 0.0, 0.0)}, {kStiffness}};
  model::State state{{Vec3::Zero(), Vec3(0.0, 4.0, 0.0)}, {Vec3::Zero(), Vec3(4.0, 5.0, 0.0)}};  // turned, and twice as long
};

TEST(Springs, PullByHookesLawAlongTheirDirection) {
  const OneSpring one;
  EXPECT_EQ(one.forces(true, 0.0), (Points{Vec3(0.0, 100.0, 0.0), Vec3(0.0, -100.0, 0.0)}));
  EXPECT_DOUBLE_EQ(one.springs.energy(one.state), 100.0);
  EXPECT_DOUBLE_EQ(one.springs.maxStretch(one.state), 1.0);
}

TEST(Springs, AreDampedAlongThemOrInEveryDirection) {
  const OneSpring one;
  EXPECT_EQ(one.forces(false, kBeta), (Points{Vec3(0.0, 31.25, 0.0), Vec3(0.0, -31.25, 0.0)}));
  Points forces(2, Vec3::Zero());
  one.springs.addRelativeDamping(one.state, kBeta, forces);
  EXPECT_EQ(forces, (Points{Vec3(25.0, 31.25, 0.0), Vec3(-25.0, -31.25, 0.0)}));
}

TEST(Springs, PushCoincidentEndsApartAlwaysTheSameWay) {
  OneSpring one;
  one.state.positions[1] = one.state.positions[0];
  const Points forces = one.forces(true, 0.0);
  EXPECT_NEAR(forces[0].norm(), kStiffness * kLength, 1e-9);
  EXPECT_EQ(forces[0], Vec3(-forces[1]));
  EXPECT_EQ(forces, one.forces(true, 0.0));
}

TEST(Springs, BoundTheRowsOfTheirStiffnessAndDamping) {
  const OneSpring one;
  std::vector<double> stiffness(2, 0.0), damping(2, 0.0);
  one.springs.addRowBounds(true, kBeta, stiffness, damping);
  for (int i = 0; i < 2; ++i) {
    EXPECT_GE(stiffness[i], 2.0 * kStiffness);
    EXPECT_GE(damping[i], 2.0 * kBeta * kStiffness);
  }
}

}  // namespace
}  // namespace deformable_surface::test
