// The pull towards an observed cloud: its law, its potential, and which points count as visible.
#include "deformable_surface/simulation/track_load.h"

#include "../support/dense.h"
#include "clouds.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using simulation::TrackLoad;

constexpr double kGain = 9.0;  // 1/s^2

struct OnePoint {
  OnePoint() { load.restore({{0, Vec3(0.0, 0.0, 0.5), Vec3(0.0, 0.6, 0.8)}}); }

  std::vector<double> masses{2.0};
  TrackLoad load{masses, kGain};
  model::State state{{Vec3(0.1, -0.2, 0.3)}, {Vec3(0.5, 0.0, 1.0)}};
};

TEST(TrackLoad, PullsToThePlaneAndIsCriticallyDampedAcrossIt) {
  const OnePoint p;
  Points forces(1, Vec3::Zero());
  p.load.addForces(0.0, p.state, forces);
  const Vec3 normal(0.0, 0.6, 0.8);
  const double away = 0.6 * 0.2 + 0.8 * 0.2;  // m, n . (p - x)
  EXPECT_LT((forces[0] - 2.0 * (kGain * away - 2.0 * 3.0 * 0.8) * normal).norm(), 1e-12);
  EXPECT_NEAR(p.load.storedEnergy(0.0, p.state), 0.5 * 2.0 * kGain * away * away, 1e-12);
  EXPECT_NEAR(p.load.residual(p.state), away, 1e-12);
}

TEST(TrackLoad, HasTheStiffnessOfItsForcesAndBoundsIt) {
  const OnePoint p;
  BlockSparse stiffness;
  stiffness.begin(1);
  p.load.addStiffness(0.0, p.state, 0.5, stiffness);
  stiffness.finish();
  const Vec3 normal(0.0, 0.6, 0.8);
  const Mat3 expected = 2.0 * (kGain + 2.0 * 3.0 / 0.5) * normal * normal.transpose();
  EXPECT_LT((makeDense(stiffness) - expected).norm(), 1e-12);
  std::vector<double> row_stiffness{0.0}, row_damping{0.0};
  p.load.addRowBounds(0.0, p.state, row_stiffness, row_damping);
  EXPECT_GE(row_stiffness[0], 2.0 * kGain);
  EXPECT_GE(row_damping[0], 2.0 * 2.0 * 3.0);
}

// A plane at z = 0.1 from x = 0 to x = 1, and points of a surface below it, beside it, and turned away from it.
TEST(TrackLoad, SeesWhatIsNearFacesTheCloudAndIsNotAside) {
  Points plane;
  for (int i = 0; i <= 20; ++i)
    for (int j = 0; j <= 20; ++j) plane.emplace_back(0.05 * i, 0.05 * j, 0.1);
  const simulation::ObservedCloud cloud(asCloud(plane));
  const Points positions{Vec3(0.5, 0.5, 0.0), Vec3(0.5, 0.5, -1.0), Vec3(1.5, 0.5, 0.0), Vec3(0.5, 0.5, 0.0)};
  const Points normals{Vec3::UnitZ(), Vec3::UnitZ(), Vec3::UnitZ(), Vec3::UnitX()};
  const std::vector<double> masses(4, 1.0);
  TrackLoad load(masses, kGain);
  const model::State state{positions, Points(4, Vec3::Zero())};
  load.observe(cloud, state, normals, 0.8);
  ASSERT_EQ(load.seen().size(), 1u);
  EXPECT_EQ(load.seen()[0].point, 0);
  EXPECT_NEAR(std::abs(load.seen()[0].normal.z()), 1.0, 1e-9);
  EXPECT_NEAR(load.residual(state), 0.1, 1e-9);
}

TEST(TrackLoad, HasNoResidualWhereNothingWasSeen) {
  const std::vector<double> masses{1.0};
  const TrackLoad load(masses, kGain);
  EXPECT_TRUE(load.isEmpty());
  EXPECT_TRUE(std::isnan(load.residual({{Vec3::Zero()}, {Vec3::Zero()}})));
}

TEST(ObservedCloud, NeedsThreeDistinctPoints) {
  EXPECT_THROW(simulation::ObservedCloud(asCloud({Vec3::Zero(), Vec3::UnitX(), Vec3::UnitX()})), InputError);
}

}  // namespace
}  // namespace deformable_surface::test
