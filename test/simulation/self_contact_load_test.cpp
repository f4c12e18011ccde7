// Contact of a surface with itself in a simulation: nothing crosses, no energy is created, and runs can be continued and copied.
#include "../../src/simulation/self_contact_load.h"
#include "clouds.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "../support/contact_scenes.h"
#include "../support/crossings.h"
#include "../support/whole_triangles.h"

namespace deformable_surface::test {
namespace {

using simulation::Simulation;
using Type = solve::IntegratorType;

ContactScene makeScene(const std::string& name, std::uint32_t seed, double duration, Type type = Type::kVerlet) {
  ContactSceneMaker maker(seed);
  for (const auto& [known, make] : listContactScenes()) {
    if (known != name) continue;
    ContactScene scene = make(maker);
    scene.params.duration = duration;
    scene.params.integrator.type = type;
    return scene;
  }
  throw InputError("contact scenes: found " + name);
}

struct Outcome {
  int crossed = 0;    // checks in which any triangles cross
  Index touched = 0;  // most pairs in contact
};
Outcome simulate(const ContactScene& scene) {
  Outcome seen;
  Simulation s(scene.params, scene.cloud);
  const std::vector<contact::Triangle> triangles = simulation::ContactSkin(s.state().positions, trianglesOf(s.model())).triangles;
  const int steps = static_cast<int>(std::lround(scene.params.duration / scene.params.integrator.time_step));
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
    if (!outcome.ok) return seen;
    if (k % 4 != 3) continue;
    seen.crossed += !findCrossings(s.state().positions, triangles).empty();
    seen.touched = std::max(seen.touched, static_cast<Index>(s.statistics().self_contacts));
  }
  return seen;
}

TEST(SelfContactLoad, AFoldedTowelDoesNotCrossItself) {
  ContactScene scene = makeScene("fold", 1, 1.0);
  const Outcome with = simulate(scene);
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

// By default there is contact where it costs little: on surfaces that lie open.
TEST(SelfContactLoad, IsOnByDefaultWhereTheSurfaceLiesOpen) {
  const auto isOn = [](const simulation::SceneParams& params, const cloud::PointCloud& cloud) {
    Simulation s(params, cloud);
    const std::vector<std::string>& notes = s.buildNotes();
    const bool is_told = std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
      return note.find("contact.self: auto is off") != std::string::npos;
    });
    Simulation fork = s.fork();
    run(s, 1);
    run(fork, 1);
    EXPECT_EQ(fork.statistics().skipped, s.statistics().skipped);
    const std::vector<std::string> skipped = s.statistics().skipped;
    const bool is_on = std::count(skipped.begin(), skipped.end(), "self_contact") > 0;
    EXPECT_EQ(is_told, params.contact.self.is_auto && !is_on);
    return is_on;
  };
  simulation::SceneParams p = hangingSheet();
  p.pins.clear();
  p.accuracy.estimate = false;
  EXPECT_TRUE(isOn(p, sheetCloud()));
  cloud::PointCloud with_hole = sheetCloud(), bowl = sheetCloud(), tube = sheetCloud();
  Points& around = with_hole.positions;
  around.erase(
      std::remove_if(around.begin(), around.end(), [](const Vec3& x) { return (x - Vec3(0.5, 0.5, x.z())).norm() < 0.2; }),
      around.end());
  with_hole.width = static_cast<std::uint32_t>(around.size());
  EXPECT_TRUE(isOn(p, with_hole));
  for (Vec3& x : bowl.positions) x.z() = (x - Vec3(0.5, 0.5, x.z())).squaredNorm();
  EXPECT_TRUE(isOn(p, bowl));
  for (Vec3& x : tube.positions) x = Vec3(0.16 * std::cos(6.08 * x.x()), x.y(), 0.16 * std::sin(6.08 * x.x()));
  EXPECT_FALSE(isOn(p, tube));
  p.contact.self = false;
  EXPECT_FALSE(isOn(p, sheetCloud()));
  p.contact.self = true;
  EXPECT_TRUE(isOn(p, tube));
  // Values that may change in a run are given with all others as they were stated.
  p.contact.self = {};
  Simulation s(p, sheetCloud());
  p.material.damping = 3.0;
  s.setParams(p);
  EXPECT_EQ(s.params().material.damping, 3.0);
}

TEST(SelfContactLoad, TellsWhyItIsOffByDefault) {
  const auto reasonOf = [](const simulation::SceneParams& params, const cloud::PointCloud& cloud) -> std::string {
    const Simulation s(params, cloud);
    for (const std::string& note : s.buildNotes())
      if (note.find("contact.self: auto is off") != std::string::npos) return note;
    return "it is on";
  };
  simulation::SceneParams p = hangingSheet();
  p.pins.clear();
  p.accuracy.estimate = false;
  EXPECT_EQ(reasonOf(p, sheetCloud()), "it is on");
  cloud::PointCloud tube = sheetCloud();
  for (Vec3& x : tube.positions) x = Vec3(0.16 * std::cos(6.08 * x.x()), x.y(), 0.16 * std::sin(6.08 * x.x()));
  EXPECT_NE(reasonOf(p, tube).find("lie over others"), std::string::npos) << reasonOf(p, tube);
  p.contact.thickness = 0.04;
  EXPECT_NE(reasonOf(p, sheetCloud()).find("thick"), std::string::npos) << reasonOf(p, sheetCloud());
  p.contact.thickness = {};
  p.integrator.type = solve::IntegratorType::kStatic;
  EXPECT_NE(reasonOf(p, sheetCloud()).find("equilibria"), std::string::npos) << reasonOf(p, sheetCloud());
  p.contact.self = true;
  EXPECT_EQ(reasonOf(p, sheetCloud()), "it is on");
}

TEST(SelfContactLoad, ATowelThatIsFoldedDoesNotCrossItselfByDefault) {
  ContactScene scene = makeScene("fold", 2, 1.0);
  scene.params.contact.self = {};
  const Outcome seen = simulate(scene);
  EXPECT_EQ(seen.crossed, 0);
  EXPECT_GT(seen.touched, 10);
}

// Layers a third of a spacing apart are bridged by the model; contact cannot use the triangles that overlap.
TEST(SelfContactLoad, WhatHasNoContactIsTold) {
  const auto firstNotice = [](int num_layers, double gap) {
    ContactScene scene = makeScene("drop", 1, 0.1);
    scene.params.contact.self = true;
    scene.params.tools.clear();
    scene.cloud = {};
    for (int layer = 0; layer < num_layers; ++layer)
      for (int i = 0; i < 12; ++i)
        for (int j = 0; j < 12; ++j) scene.cloud.positions.emplace_back(0.022 * i, 0.022 * j, gap * layer);
    scene.cloud.width = static_cast<Index>(scene.cloud.positions.size());
    Simulation s(scene.params, scene.cloud);
    return s.step().notice;
  };
  EXPECT_EQ(firstNotice(1, 0.05).find("no contact with itself"), std::string::npos);
  EXPECT_EQ(firstNotice(3, 0.05).find("no contact with itself"), std::string::npos);
  EXPECT_NE(firstNotice(3, 0.007).find("no contact with itself"), std::string::npos);
}

// Triangles of the surface that overlap on a rough sheet: an edge of one passes through the other, with which it shares a vertex.
TEST(SelfContactLoad, OfTrianglesThatPassThroughTheirNeighboursTheLargerHasNoContact) {
  const Points rest = {Vec3(0.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), Vec3(0.5, 0.5, 0.3), Vec3(0.1, 0.1, -0.3)};
  const std::vector<model::WeightedTriangle> triangles = {{{0, 1, 2}, 1.0}, {{0, 3, 4}, 1.0}};
  const std::vector<contact::Triangle> chosen = simulation::ContactSkin(rest, triangles).triangles;
  ASSERT_EQ(chosen.size(), 1u);
  EXPECT_EQ(chosen[0], (contact::Triangle{0, 3, 4}));
  // The edge is that of the larger triangle.
  const Points long_edge = {rest[0], rest[1], rest[2], Vec3(1.7, 1.7, 1.5), Vec3(-1.1, -1.1, -1.5)};
  EXPECT_EQ(simulation::ContactSkin(long_edge, triangles).triangles, (std::vector<contact::Triangle>{{0, 1, 2}}));
  // Without a common vertex they may be two layers.
  const Points apart = {rest[0], rest[1], rest[2], rest[3], rest[4], Vec3(0.5, 0.2, 0.5)};
  EXPECT_EQ(simulation::ContactSkin(apart, {{{0, 1, 2}, 1.0}, {{3, 4, 5}, 1.0}}).triangles.size(), 2u);
}

TEST(SelfContactLoad, AThicknessOfSpacingsIsWarnedOf) {
  ContactScene scene = makeScene("drop", 1, 0.1);
  EXPECT_TRUE(Simulation(scene.params, scene.cloud).buildWarnings().empty());
  scene.params.contact.thickness = 0.08;
  const std::vector<std::string> warnings = Simulation(scene.params, scene.cloud).buildWarnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("contact.thickness is "), std::string::npos) << warnings[0];
}

TEST(SelfContactLoad, AThicknessBeyondTheSurfaceIsRefused) {
  ContactScene scene = makeScene("drop", 1, 0.1);
  scene.params.contact.thickness = 10.0;
  try {
    Simulation s(scene.params, scene.cloud);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("contact.thickness: found 10 m; accepted: below 0."), std::string::npos)
        << error.what();
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
    const Outcome seen = simulate(makeScene(name, 2, 0.8));
    EXPECT_EQ(seen.crossed, 0) << name;
    EXPECT_GT(seen.touched, 10) << name;
  }
}

TEST(SelfContactLoad, ImplicitStepsDoNotCrossEither) {
  const Outcome seen = simulate(makeScene("drop", 1, 0.6, Type::kImplicit));
  EXPECT_EQ(seen.crossed, 0);
  EXPECT_GT(seen.touched, 2);
}

// A sheet that pins press into a larger one, in register and not. Each step used to end far from balance: the damping of springs
// set in at once, edges were parallel, and what springs did not bear the limit of motion did.
TEST(SelfContactLoad, ImplicitStepsBalanceLayersThatArePressedTogether) {
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
TEST(SelfContactLoad, ImplicitStepsSlowDownNoPartThatNothingTouches) {
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

// A sleeve that is forced through its own end, a strip that is twisted, a tube that plates press flat. Parts that press on each
// other used to be driven apart: a twentieth to a tenth of the energy stored in strip and tube came from nothing.
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

TEST(SelfContactLoad, ARunFromASnapshotAndAForkAreTheSame) {
  ContactScene scene = makeScene("fold", 1, 1.0);
  scene.params.contact.friction = 0.3;
  Simulation s(scene.params, scene.cloud);
  run(s, 150);
  ASSERT_GT(s.statistics().self_contacts, 0u);
  const simulation::Snapshot snapshot = s.snapshot();
  Simulation fork = s.fork();
  run(s, 30);
  run(fork, 30);
  EXPECT_EQ(s.stateHash(), fork.stateHash());
  const std::uint64_t hash = s.stateHash();
  s.restore(snapshot);
  run(s, 30);
  EXPECT_EQ(s.stateHash(), hash);
}

// Also before anything touches, where a proof that nothing does serves several steps.
TEST(SelfContactLoad, AnotherSimulationContinuesASnapshot) {
  ContactScene scene = makeScene("drop", 4, 1.0);
  Simulation whole(scene.params, scene.cloud);
  std::vector<simulation::Snapshot> snapshots;
  Index touched = 0;
  for (int step = 0; step < 90; ++step) {
    if (step % 15 == 4) snapshots.push_back(whole.snapshot());
    run(whole, 1);
    touched += step == 5 || step == 89 ? static_cast<Index>(whole.statistics().self_contacts) : 0;
  }
  EXPECT_GT(touched, 0);
  for (std::size_t k = 0; k < snapshots.size(); ++k) {
    Simulation rest(scene.params, scene.cloud);
    run(rest, 3);
    rest.restore(snapshots[k]);
    run(rest, 86 - 15 * static_cast<int>(k));
    EXPECT_EQ(rest.stateHash(), whole.stateHash()) << k;
  }
  whole.reset();
  run(whole, 90);
  Simulation again(scene.params, scene.cloud);
  run(again, 90);
  EXPECT_EQ(whole.stateHash(), again.stateHash());
}

// The matrix of an implicit step has blocks of the pairs in contact. Those of earlier steps must not stay in it.
TEST(SelfContactLoad, AnImplicitRunFromASnapshotIsTheSame) {
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

TEST(SelfContactLoad, ResultsDoNotDependOnTheNumberOfThreads) {
  ContactScene scene = makeScene("drop", 4, 0.6);
  std::uint64_t hash = 0;
  for (const Index threads : {1, 2, 3}) {
    scene.params.threads = threads;
    Simulation s(scene.params, scene.cloud);
    run(s, 80);
    if (threads == 1) hash = s.stateHash();
    EXPECT_EQ(s.stateHash(), hash) << threads;
  }
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

// The number of triangles that are cut or torn, and the largest number of contacts, in a run in which nothing may cross.
std::pair<std::size_t, Index> runWithCuts(const ContactScene& scene, int steps) {
  Simulation s(scene.params, scene.cloud);
  const simulation::ContactSkin skin(s.state().positions, trianglesOf(s.model()));
  std::size_t cut = 0;
  Index touched = 0;
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << k << ": " << outcome.problem;
    if (!outcome.ok) break;
    const std::vector<contact::Triangle> whole = listWhole(skin, s.model());
    cut = std::max(cut, skin.triangles.size() - whole.size());
    EXPECT_TRUE(findCrossings(s.state().positions, whole).empty()) << k;
    touched = std::max(touched, static_cast<Index>(s.statistics().self_contacts));
  }
  return {cut, touched};
}

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

TEST(SelfContactLoad, EquilibriaDoNotCrossOnTheirWay) {
  ContactScene scene = makeLayers(0.03);
  const Outcome seen = simulate(scene);
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

TEST(SelfContactLoad, EquilibriaThatAreSearchedTwiceCanBeRepeated) {
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

TEST(SelfContactLoad, EquilibriaWhereNothingIsNearHaveTheBitsOfThoseWithoutContact) {
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

TEST(SelfContactLoad, WhatIsCutOrTornDoesNotCrossItself) {
  for (const char* name : {"cut_and_drop", "tear_twisted"}) {
    const auto [cut, touched] = runWithCuts(makeScene(name, 3, 0.8), 160);
    EXPECT_GT(cut, 0u) << name;
    EXPECT_GT(touched, 0) << name;
  }
  EXPECT_GT(runWithCuts(makeScene("cut_and_drop", 3, 0.8, Type::kImplicit), 80).first, 0u);
}

TEST(SelfContactLoad, TheRunOfACutSurfaceCanBeContinuedCopiedAndReset) {
  ContactScene scene = makeScene("cut_and_drop", 5, 0.8);
  scene.params.contact.friction = 0.3;
  std::uint64_t hash = 0;
  for (const Index threads : {1, 2}) {
    scene.params.threads = threads;
    Simulation s(scene.params, scene.cloud);
    run(s, 40);
    const simulation::Snapshot before = s.snapshot();
    run(s, 80);
    const simulation::Snapshot snapshot = s.snapshot();
    Simulation fork = s.fork();
    run(s, 30);
    run(fork, 30);
    EXPECT_EQ(s.stateHash(), fork.stateHash());
    if (threads == 1) hash = s.stateHash();
    EXPECT_EQ(s.stateHash(), hash);
    s.restore(before);
    run(s, 80);
    Simulation again = s.fork();
    run(again, 30);
    EXPECT_EQ(again.stateHash(), hash);
    s.restore(snapshot);
    run(s, 30);
    EXPECT_EQ(s.stateHash(), hash);
    s.reset();
    run(s, 150);
    EXPECT_EQ(s.stateHash(), hash);
  }
}

}  // namespace
}  // namespace deformable_surface::test
