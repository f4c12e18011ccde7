#include "../../src/solve/bearing_parts.h"

#include <gtest/gtest.h>

#include "oscillators.h"

namespace deformable_surface::test {
namespace {

class NoLimit : public solve::MotionLimit {
 public:
  explicit NoLimit(std::vector<Index> parts) : parts_(std::move(parts)) {}
  const std::vector<Index>& limit(const Points&, Points&, bool) const override { return stopped_; }
  const std::vector<Index>& parts() const override { return parts_; }

 private:
  const std::vector<Index> stopped_, parts_;
};

// Two points of part 0, a third of part 2, a fourth of part 3 that is held; 2 kg each.
struct World {
  World() : model({0.0, 0.0, 0.0, 0.0}, 2.0), system(model, loads, held, 0.0), limit({0, 0, 2, 3}) {
    system.setMotionLimit(&limit);
    bearing.begin(system);
  }
  Oscillators model;
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held{0, 0, 0, 1};
  solve::System system;
  NoLimit limit;
  solve::BearingParts bearing;
  State state{Points(4, Vec3::Zero()), {Vec3(3.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0), Vec3(0.0, 5.0, 0.0), Vec3(0.0, 0.0, 7.0)}};
};

TEST(BearingParts, OnlyFreePointsOfStoppedPartsBear) {
  World world;
  EXPECT_FALSE(world.bearing.areAnyFree(world.system));
  world.bearing.addStopped(world.limit, {3});
  EXPECT_FALSE(world.bearing.areAnyFree(world.system));
  world.bearing.addStopped(world.limit, {1});
  EXPECT_TRUE(world.bearing.contains(world.system, 0));
  EXPECT_FALSE(world.bearing.contains(world.system, 2));
  EXPECT_FALSE(world.bearing.contains(world.system, 3));
}

TEST(BearingParts, TakeEnergyAndKeepMomentum) {
  World world;
  world.bearing.addPart(0);
  const double before = world.system.kineticEnergy(world.state);
  EXPECT_DOUBLE_EQ(world.bearing.take(world.system, 0.5, world.state), 0.5);
  EXPECT_NEAR(world.system.kineticEnergy(world.state), before - 0.5, 1e-12);
  EXPECT_NEAR(world.state.velocities[0].x() + world.state.velocities[1].x(), 4.0, 1e-12);
  EXPECT_EQ(world.state.velocities[2], Vec3(0.0, 5.0, 0.0));
  EXPECT_EQ(world.state.velocities[3], Vec3(0.0, 0.0, 7.0));
}

TEST(BearingParts, TakeNoMoreThanThereIs) {
  World world;
  world.bearing.addPart(0);
  EXPECT_NEAR(world.bearing.take(world.system, 100.0, world.state), 2.0, 1e-12);
  EXPECT_EQ(world.state.velocities[0], world.state.velocities[1]);
  EXPECT_NEAR(world.bearing.take(world.system, 100.0, world.state, false), 8.0, 1e-12);
  EXPECT_EQ(world.state.velocities[0], Vec3::Zero());
}

TEST(BearingParts, AreThoseWhoseMotionTheForcesDoNotExplain) {
  World world;
  const State before = world.state;
  world.state.velocities[1].x() = 2.0;
  world.bearing.addChanged(world.system, 0.0, 0.01, before, world.state);
  EXPECT_TRUE(world.bearing.contains(world.system, 1));
  EXPECT_FALSE(world.bearing.contains(world.system, 2));
}

}  // namespace
}  // namespace deformable_surface::test
