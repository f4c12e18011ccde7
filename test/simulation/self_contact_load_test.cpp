// Contact of a surface with itself in a simulation: nothing crosses, no energy is created, and nothing acts where nothing is
// near.
#include "../../src/simulation/self_contact_load.h"
#include "self_contact_runs.h"

#include <random>

namespace deformable_surface::test {
namespace {

using simulation::Simulation;

TEST(SelfContactLoad, AFoldedTowelDoesNotCrossItself) {
  ContactScene scene = makeScene("fold", 1, 1.0);
  const SelfContactOutcome with = simulate(scene);
  EXPECT_EQ(with.crossed, 0);
  EXPECT_GT(with.touched, 10);
  scene.params.contact.self = false;
  EXPECT_GT(simulate(scene).crossed, 10);
}

// Checked by the model's own triangles within a layer, not by those of contact.
TEST(SelfContactLoad, LayersThatPinsPullBetweenCylindersDoNotCross) {
  const auto countCrossedSteps = [](ContactScene scene, bool self) {
    scene.params.contact.self = self;
    Simulation s(scene.params, scene.cloud);
    const Points rest = s.state().positions;
    const auto isUpper = [&](Index v) { return rest[v].z() > 0.0; };
    std::vector<contact::Triangle> within;
    for (const model::WeightedTriangle& t : trianglesOf(s.model()))
      if (t.weight > 0.99 && std::count_if(t.corner, t.corner + 3, isUpper) % 3 == 0)
        within.push_back({t.corner[0], t.corner[1], t.corner[2]});
    int crossed = 0;
    for (int k = 0; k < 80; ++k) {
      run(s, 1);
      const auto crossings = findCrossings(s.state().positions, within);
      crossed += std::any_of(crossings.begin(), crossings.end(),
                             [&](const auto& pair) { return isUpper(within[pair.first][0]) != isUpper(within[pair.second][0]); });
    }
    return crossed;
  };
  for (const std::uint32_t seed : {1u, 7u}) {
    const ContactScene scene = ContactSceneMaker(seed).pulledLayers();
    EXPECT_EQ(countCrossedSteps(scene, true), 0) << seed;
    EXPECT_GT(countCrossedSteps(scene, false), 10) << seed;
  }
}

// Layers of 9 x 9 points fall on each other, and a hand pulls the upper one away.
TEST(SelfContactLoad, SoftAndThinLayersSlideOnEachOtherWithoutFriction) {
  struct Fabric {
    double young_modulus, thickness, density;
  };
  constexpr Index kAcross = 9, kLayers = 4, kLayer = kAcross * kAcross;
  constexpr double kSize = 0.3, kSpacing = kSize / (kAcross - 1), kPull = 0.2, kAside = 0.09;
  for (const Fabric& fabric : {Fabric{3e4, 0.002, 1000.0}, Fabric{3e5, 0.0002, 250.0}}) {
    simulation::SceneParams p;
    p.material.young_modulus = fabric.young_modulus;
    p.material.thickness = fabric.thickness;
    p.material.density = fabric.density;
    p.material.damping = 1.0;
    p.simplification.method = cloud::SimplificationMethod::kNone;
    p.contact.self = true;
    p.accuracy.estimate = false;
    p.integrator.time_step = 0.005;
    tool::ToolParams table, hand;
    table.id = "table";
    table.friction = 0.3;
    table.shape.kind = geometry::Solid::Kind::kPlane;
    table.path = {{0.0, Vec3::Zero(), Vec4(0.0, 0.0, 0.0, 1.0)}};
    hand.id = "hand";
    hand.mode = tool::Mode::kMove;
    hand.start = 0.35;
    hand.shape.kind = geometry::Solid::Kind::kBox;
    hand.shape.size = Vec3(0.06, 0.4, 0.1);
    hand.path = {{0.35, Vec3(0.5 * kSize + 0.8 * kAside, 0.0, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)},
                 {0.75, Vec3(0.5 * kSize + 0.8 * kAside + kPull, 0.0, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)}};
    p.tools = {table, hand};
    cloud::PointCloud cloud;
    std::mt19937 generator(4);
    std::uniform_real_distribution<double> jitter(-0.1 * kSpacing, 0.1 * kSpacing);
    for (Index layer = 0; layer < kLayers; ++layer)
      for (Index i = 0; i < kLayer; ++i)
        cloud.positions.emplace_back(
            kSpacing * (i / kAcross) - 0.5 * kSize + jitter(generator) + (layer + 1 == kLayers ? kAside : 0.0),
            kSpacing * (i % kAcross) - 0.5 * kSize + jitter(generator), 0.002 + 0.03 * layer);
    Simulation s(p, cloud);
    const Points rest = s.state().positions;
    run(s, 160);
    for (Index layer = 0; layer < kLayers; ++layer) {
      double moved = 0.0;
      for (Index i = layer * kLayer; i < (layer + 1) * kLayer; ++i) moved += (s.state().positions[i].x() - rest[i].x()) / kLayer;
      if (layer + 1 < kLayers)
        EXPECT_LT(std::abs(moved), 0.05) << fabric.thickness << " m, layer " << layer;
      else
        EXPECT_GT(moved, 0.9 * kPull) << fabric.thickness << " m";
    }
  }
}

TEST(SelfContactLoad, TouchesTellEachForceWithItsPlace) {
  ContactScene scene = makeScene("fold", 1, 1.0);
  scene.params.contact.friction = 0.3;
  Simulation s(scene.params, scene.cloud);
  for (int k = 0; k < 150; ++k) ASSERT_TRUE(s.step().ok);
  const std::vector<simulation::SelfTouch> touches = s.selfTouches();
  ASSERT_GT(touches.size(), 10u);
  EXPECT_EQ(touches.size(), s.statistics().self_contacts);
  double least = 1.0;
  for (const simulation::SelfTouch& touch : touches) {
    Vec3 gap = Vec3::Zero();
    double sum = 0.0, size = 0.0;
    for (int v = 0; v < 4; ++v) {
      gap += touch.weights[v] * s.state().positions[touch.points[v]];
      sum += touch.weights[v];
      size += std::abs(touch.weights[v]);
    }
    EXPECT_NEAR(sum, 0.0, 1e-12);
    EXPECT_NEAR(size, 2.0, 1e-12);
    EXPECT_LT((gap - gap.norm() * touch.normal).norm(), 1e-9 * gap.norm());
    EXPECT_GT(touch.depth, 0.0);
    EXPECT_GT(touch.force.dot(touch.normal), 0.0);
    least = std::min(least, gap.norm());
  }
  EXPECT_DOUBLE_EQ(least, s.statistics().self_distance);
}

TEST(SelfContactLoad, ATwistedStripAndAHeapDoNotCrossThemselves) {
  for (const char* name : {"twist", "heap"}) {
    const SelfContactOutcome seen = simulate(makeScene(name, 2, 0.8));
    EXPECT_EQ(seen.crossed, 0) << name;
    EXPECT_GT(seen.touched, 10) << name;
  }
}

// A sleeve that is forced through its own end, a strip that is twisted, a tube that plates press flat. Contact
// must not drive parts apart that press on each other.
TEST(SelfContactLoad, JamsMakeNoEnergy) {
  const auto check = [](ContactScene scene, double friction) {
    scene.params.contact.friction = friction;
    Simulation s(scene.params, scene.cloud);
    double stored = 0.0, excess = 0.0;  // J
    for (int step = 0; step < 200; ++step) {
      ASSERT_TRUE(s.step().ok);
      stored = std::max(stored, s.statistics().kinetic_energy + s.statistics().elastic_energy);
      excess = std::max(excess, s.energyExcess());
    }
    EXPECT_LT(excess, 0.003 * stored);
  };
  check(ContactSceneMaker(2, 10).sleeve(), 0.3);
  check(ContactSceneMaker(4, 10).sleeve(), 0.3);
  check(ContactSceneMaker(8, 10).twist(), 0.3);
  check(ContactSceneMaker(5, 10).flattenTube(), 0.0);
}

TEST(SelfContactLoad, NothingActsWhereNothingIsNear) {
  ContactScene scene = makeScene("fold", 1, 1.0);
  Simulation s(scene.params, scene.cloud);
  run(s, 1);
  const std::vector<std::string> skipped = s.statistics().skipped;
  EXPECT_EQ(std::count(skipped.begin(), skipped.end(), "self_contact"), 1);
  EXPECT_EQ(s.statistics().self_contacts, 0u);
}

TEST(SelfContactLoad, WhereNothingComesNearTheBitsAreThoseWithoutContact) {
  for (const double tilt : {0.0, 0.7}) {
    simulation::SceneParams p = hangingSheet();
    p.gravity = Vec3(0.0, 9.81 * std::sin(tilt), -9.81 * std::cos(tilt));
    std::uint64_t hash = 0;
    for (const bool meets_itself : {false, true}) {
      p.contact.self = meets_itself;
      Simulation s(p, sheetCloud());
      run(s, 60);
      if (!meets_itself) hash = s.stateHash();
      EXPECT_EQ(s.stateHash(), hash) << tilt;
    }
  }
}

}  // namespace
}  // namespace deformable_surface::test
