// Contact of a surface with itself in implicit steps: nothing crosses, layers come to a balance, and other parts go on.
#include "../../src/simulation/self_contact_load.h"
#include "self_contact_runs.h"

namespace deformable_surface::test {
namespace {

using simulation::Simulation;
using Type = solve::IntegratorType;

TEST(SelfContactImplicit, ImplicitStepsDoNotCrossEither) {
  const SelfContactOutcome seen = simulate(makeScene("drop", 1, 0.6, Type::kImplicit));
  EXPECT_EQ(seen.crossed, 0);
  EXPECT_GT(seen.touched, 2);
}

// A sheet that pins press into a larger one, in register and not: edges are parallel, the damping of springs sets in at once, and
// springs bear the load, not the limit of motion.
TEST(SelfContactImplicit, ImplicitStepsBalanceLayersThatArePressedTogether) {
  for (const double offset : {0.0, 0.007}) {
    ContactScene scene;
    scene.params.material.young_modulus = 1e5;
    scene.params.material.thickness = 0.002;
    scene.params.material.damping = 4.0;
    scene.params.gravity.setZero();
    scene.params.simplification.method = cloud::SimplificationMethod::kNone;
    scene.params.contact.self = true;
    scene.params.contact.thickness = 0.005;
    scene.params.contact.friction = 0.3;
    scene.params.integrator.type = Type::kImplicit;
    for (int layer = 0; layer < 2; ++layer) {
      const int across = layer == 0 ? 12 : 7;
      const double from = layer == 0 ? 0.0 : 0.05 + offset;
      for (int i = 0; i < across; ++i)
        for (int j = 0; j < across; ++j) scene.cloud.positions.push_back({from + 0.02 * i, from + 0.02 * j, 0.08 * layer});
    }
    scene.cloud.width = static_cast<std::uint32_t>(scene.cloud.positions.size());
    const auto pin = [&](const Vec3& min, const Vec3& max) {
      scene.params.pins.emplace_back();
      scene.params.pins.back().region.min = min;
      scene.params.pins.back().region.max = max;
    };
    pin({-0.01, -0.01, -0.01}, {0.005, 0.3, 0.01});
    pin({0.215, -0.01, -0.01}, {0.225, 0.3, 0.01});
    pin({0.04, 0.04, 0.07}, {0.3, offset + 0.055, 0.09});
    pin({0.04, offset + 0.165, 0.07}, {0.3, 0.18, 0.09});
    const Vec4 still(0.0, 0.0, 0.0, 1.0);
    for (std::size_t p : {2, 3}) scene.params.pins[p].path = {{0.0, Vec3::Zero(), still}, {0.5, Vec3(0.0, 0.0, -0.11), still}};
    Simulation s(scene.params, scene.cloud);
    Index touched = 0;
    for (int k = 0; k < 50; ++k) {
      const simulation::StepOutcome outcome = s.step();
      ASSERT_TRUE(outcome.ok) << outcome.problem;
      EXPECT_TRUE(outcome.has_converged) << offset << ' ' << k << ' ' << outcome.notice;
      touched = std::max(touched, static_cast<Index>(s.statistics().self_contacts));
    }
    EXPECT_GT(touched, 30);
  }
}

// Boxes press three layers to half of their thickness, or through each other. A patch falls beside them. It once was half of its
// way behind. Steps of implicit Euler, which take over in impacts, are late by half a step.
TEST(SelfContactImplicit, ImplicitStepsSlowDownNoPartThatNothingTouches) {
  for (const bool self : {true, false}) {
    ContactScene scene;
    scene.params.material.young_modulus = 3e4;
    scene.params.material.density = 300.0;
    scene.params.material.thickness = 0.004;
    scene.params.simplification.method = cloud::SimplificationMethod::kNone;
    scene.params.contact.self = self;
    scene.params.integrator.type = Type::kImplicit;
    scene.params.integrator.time_step = 0.004;
    const int across = 6;
    for (int layer = 0; layer < 4; ++layer)
      for (int i = 0; i < across; ++i)
        for (int j = 0; j < across; ++j) {
          const double shift = layer == 1 ? 0.007 : 0.0, aside = layer == 3 ? 0.5 : 0.0;
          scene.cloud.positions.push_back({aside + shift + 0.02 * i, shift + 0.02 * j, layer == 3 ? 0.0 : 0.06 * (layer - 1)});
        }
    scene.cloud.width = static_cast<std::uint32_t>(scene.cloud.positions.size());
    const Vec4 still(0.0, 0.0, 0.0, 1.0);
    for (const double side : {-1.0, 1.0}) {
      tool::ToolParams box;
      box.id = side < 0.0 ? "below" : "above";
      box.shape.kind = geometry::Solid::Kind::kBox;
      box.shape.size = Vec3(0.3, 0.3, 0.06);
      box.path = {{0.0, Vec3(0.05, 0.05, side * 0.1), still}, {0.06, Vec3(0.05, 0.05, side * 0.033), still}};
      scene.params.tools.push_back(box);
    }
    Simulation s(scene.params, scene.cloud);
    Index touched = 0;
    for (int k = 0; k < 40; ++k) {
      const simulation::StepOutcome outcome = s.step();
      ASSERT_TRUE(outcome.ok) << outcome.problem;
      touched = std::max(touched, static_cast<Index>(s.statistics().self_contacts));
    }
    if (self) {
      EXPECT_GT(touched, 50);
    }
    const double fallen = 0.5 * 9.81 * s.time() * s.time();
    for (Index i = 3 * across * across; i < s.state().size(); ++i)
      EXPECT_NEAR(s.state().positions[i].z(), -fallen, (self ? 1e-4 : 5e-3) * fallen);
  }
}

// The matrix of an implicit step has blocks of the pairs in contact. Those of earlier steps must not stay in it.
TEST(SelfContactImplicit, AnImplicitRunFromASnapshotIsTheSame) {
  Simulation s = [] {
    ContactScene scene = ContactSceneMaker(3, 8).drop();
    scene.params.integrator.type = Type::kImplicit;
    return Simulation(scene.params, scene.cloud);
  }();
  for (int step = 0; step < 120 && s.statistics().self_contacts == 0; ++step) run(s, 1);
  ASSERT_GT(s.statistics().self_contacts, 0u);
  for (int start = 0; start < 3; ++start) {
    run(s, 3);
    const simulation::Snapshot snapshot = s.snapshot();
    run(s, 10);
    const std::uint64_t hash = s.stateHash();
    s.restore(snapshot);
    run(s, 10);
    EXPECT_EQ(s.stateHash(), hash) << start;
  }
}

}  // namespace
}  // namespace deformable_surface::test
