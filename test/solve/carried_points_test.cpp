// What carries a point bears the force on it.
#include "../../src/solve/carried_points.h"

#include <gtest/gtest.h>

#include "oscillators.h"

namespace deformable_surface::solve {
namespace {

constexpr double kStiffness = 7.0;  // N/m

TEST(CarriedPoints, AreThoseThatAreHeldAndMove) {
  const test::Oscillators springs({kStiffness, kStiffness, kStiffness}, 1.0);
  const std::vector<const ExternalLoad*> loads;
  const std::vector<char> held{1, 0, 1};
  const System system(springs, loads, held, 0.0);
  model::State state;
  state.positions.assign(3, Vec3::UnitX());
  state.velocities = {Vec3::Zero(), Vec3::UnitY(), Vec3::UnitZ()};
  std::vector<CarriedPoint> carried;
  findCarried(system, state, carried);
  ASSERT_EQ(carried.size(), 1u);
  EXPECT_EQ(carried[0].point, 2);
  EXPECT_EQ(carried[0].velocity, Vec3::UnitZ());
}

TEST(CarriedPoints, TheirWorkStretchesASpring) {
  CarryingWork work{Vec3::Zero()};
  double sum = 0.0;
  for (const Vec3& place : {Vec3(0.1, 0.0, 0.0), Vec3(0.1, 0.3, 0.0), Vec3(0.2, 0.2, -0.1)})
    sum += work.moveTo(place, -kStiffness * place);
  EXPECT_NEAR(sum, 0.5 * kStiffness * 0.09, 1e-15);  // exact for forces that are linear along the way
}

}  // namespace
}  // namespace deformable_surface::solve
