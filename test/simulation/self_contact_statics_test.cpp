// Contact of a surface with itself in equilibria.
#include "../../src/simulation/self_contact_load.h"
#include "self_contact_runs.h"

namespace deformable_surface::test {
namespace {

using simulation::Simulation;
using Type = solve::IntegratorType;

// Two sheets over each other. The sides of the upper one are carried down by a way, m, in ten steps.
ContactScene makeLayers(double way) {
  ContactScene scene;
  simulation::SceneParams& p = scene.params;
  p.contact.self = true;
  p.gravity.setZero();
  p.material.young_modulus = 1e5;
  p.material.thickness = 0.001;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.accuracy.estimate = false;
  p.integrator.type = Type::kStatic;
  p.integrator.time_step = 0.01;
  p.duration = 0.1;
  for (const double height : {0.0, 0.02}) {
    for (Vec3 point : makeSheet(7, 7, 0.1, 0.1, 0.2).points) scene.cloud.positions.push_back(point + Vec3(0.0, 0.0, height));
    for (const double side : {0.0, 0.1}) {
      simulation::PinParams pin;
      pin.region.min = Vec3(side - 0.001, -1.0, height - 0.005);
      pin.region.max = Vec3(side + 0.001, 1.0, height + 0.005);
      if (height > 0.0)
        pin.path = {{0.0, Vec3::Zero(), Vec4(0.0, 0.0, 0.0, 1.0)}, {0.1, Vec3(0.0, 0.0, -way), Vec4(0.0, 0.0, 0.0, 1.0)}};
      p.pins.push_back(pin);
    }
  }
  scene.cloud.width = static_cast<std::uint32_t>(scene.cloud.positions.size());
  return scene;
}

TEST(SelfContactStatics, EquilibriaDoNotCrossOnTheirWay) {
  ContactScene scene = makeLayers(0.03);
  const SelfContactOutcome seen = simulate(scene);
  EXPECT_EQ(seen.crossed, 0);
  EXPECT_GT(seen.touched, 10);
  for (const bool self : {false, true}) {
    scene.params.contact.self = self;
    Simulation s(scene.params, scene.cloud);
    run(s, 10);
    const Points& at = s.state().positions;
    const bool is_above = at[49 + 24].z() > at[24].z();  // in the middle
    EXPECT_EQ(is_above, self);
  }
}

TEST(SelfContactStatics, EquilibriaThatAreSearchedTwiceCanBeRepeated) {
  ContactScene scene = makeLayers(0.03);
  std::uint64_t hash = 0;
  for (const Index threads : {1, 2, 3}) {
    scene.params.threads = threads;
    Simulation s(scene.params, scene.cloud);
    run(s, 5);
    const simulation::Snapshot snapshot = s.snapshot();
    Simulation fork = s.fork();
    run(s, 5);
    if (threads == 1) hash = s.stateHash();
    EXPECT_EQ(s.stateHash(), hash) << threads;
    run(fork, 5);
    EXPECT_EQ(fork.stateHash(), hash) << threads;
    s.restore(snapshot);
    run(s, 5);
    EXPECT_EQ(s.stateHash(), hash) << threads;
  }
}

TEST(SelfContactStatics, EquilibriaWhereNothingIsNearHaveTheBitsOfThoseWithoutContact) {
  ContactScene scene = makeLayers(0.01);
  scene.params.forces.push_back({"push", Vec3(0.05, 0.05, 0.0), Vec3(0.0, 0.0, -0.01), 0.03, 0.0, 1e300});
  std::uint64_t hash = 0;
  for (const bool self : {false, true}) {
    scene.params.contact.self = self;
    Simulation s(scene.params, scene.cloud);
    run(s, 10);
    if (!self) hash = s.stateHash();
    EXPECT_EQ(s.stateHash(), hash);
    EXPECT_EQ(s.statistics().stopped_points, 0u);
  }
}

}  // namespace
}  // namespace deformable_surface::test
