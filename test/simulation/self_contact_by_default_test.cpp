// Where a surface has contact with itself by default, and what a user is told of where it has none.
#include "../../src/simulation/self_contact_load.h"
#include "self_contact_runs.h"

namespace deformable_surface::test {
namespace {

using simulation::Simulation;

// Open along a slit of the remaining angle, rad.
cloud::PointCloud makeTube(double angle) {
  cloud::PointCloud tube = sheetCloud();
  for (Vec3& x : tube.positions) x = Vec3(0.16 * std::cos(angle * x.x()), x.y(), 0.16 * std::sin(angle * x.x()));
  return tube;
}

// What the log says of it where it is off; empty: nothing.
std::string whyOff(const Simulation& s) {
  for (const std::string& note : s.buildNotes())
    if (note.find("contact.self: auto is off") != std::string::npos) return note;
  return {};
}

TEST(SelfContactByDefault, IsOnForSurfacesOfWhichNoPartsAreNearEachOtherAtRest) {
  const auto isOn = [](const simulation::SceneParams& params, const cloud::PointCloud& cloud) {
    Simulation s(params, cloud);
    Simulation fork = s.fork();
    run(s, 1);
    run(fork, 1);
    EXPECT_EQ(fork.statistics().skipped, s.statistics().skipped);
    const std::vector<std::string> skipped = s.statistics().skipped;
    const bool is_on = std::count(skipped.begin(), skipped.end(), "self_contact") > 0;
    EXPECT_EQ(whyOff(s) != "", params.contact.self.is_auto && !is_on);
    return is_on;
  };
  simulation::SceneParams p = hangingSheet();
  p.pins.clear();
  p.accuracy.estimate = false;
  EXPECT_TRUE(isOn(p, sheetCloud()));
  cloud::PointCloud with_hole = sheetCloud(), bowl = sheetCloud();
  Points& around = with_hole.positions;
  around.erase(
      std::remove_if(around.begin(), around.end(), [](const Vec3& x) { return (x - Vec3(0.5, 0.5, x.z())).norm() < 0.2; }),
      around.end());
  with_hole.width = static_cast<std::uint32_t>(around.size());
  EXPECT_TRUE(isOn(p, with_hole));
  for (Vec3& x : bowl.positions) x.z() = (x - Vec3(0.5, 0.5, x.z())).squaredNorm();
  EXPECT_TRUE(isOn(p, bowl));
  EXPECT_FALSE(isOn(p, makeTube(5.6)));
  p.simplification.target_points = 600;
  EXPECT_TRUE(isOn(p, makeTube(5.0)));
  EXPECT_TRUE(isOn(p, asCloud(makeSphere(500, 0.16).points)));
  p.contact.self = false;
  EXPECT_FALSE(isOn(p, sheetCloud()));
  p.contact.self = true;
  EXPECT_TRUE(isOn(p, makeTube(5.6)));
  // Values that may change in a run are given with all others as they were stated.
  p.contact.self = {};
  Simulation s(p, sheetCloud());
  p.material.damping = 3.0;
  s.setParams(p);
  EXPECT_EQ(s.params().material.damping, 3.0);
}

TEST(SelfContactByDefault, TellsWhyItIsOffByDefault) {
  simulation::SceneParams p = hangingSheet();
  p.pins.clear();
  p.accuracy.estimate = false;
  const std::string why = whyOff(Simulation(p, makeTube(5.6)));
  EXPECT_NE(why.find("parts are near each other at rest"), std::string::npos) << why;
  EXPECT_NE(why.find("true switches it on"), std::string::npos) << why;
  p.integrator.type = solve::IntegratorType::kStatic;
  EXPECT_NE(whyOff(Simulation(p, sheetCloud())).find("equilibria"), std::string::npos);
  p.contact.self = true;
  EXPECT_EQ(whyOff(Simulation(p, sheetCloud())), "");
}

// A planar solid has no contact with itself that could be switched on.
TEST(SelfContactByDefault, NamesNoKeyThatWouldBeRefused) {
  simulation::SceneParams p;
  p.model = "elastic_solid";
  p.accuracy.estimate = false;
  const std::string why = whyOff(Simulation(p, asCloud(makeSheet(12, 12, 1.0, 1.0, 0.2).points)));
  EXPECT_NE(why.find("planar solids have none"), std::string::npos) << why;
  EXPECT_EQ(why.find("switches it on"), std::string::npos) << why;
}

// A closed surface that only bends and stretches moves as without contact, and no pairs are looked for.
TEST(SelfContactByDefault, CostsAClosedSurfaceNoSearchWhereNothingIsNear) {
  simulation::SceneParams p;
  p.material.young_modulus = 1e5;
  p.material.thickness = 0.001;
  p.material.damping = 10.0;
  p.gravity.setZero();
  p.pressure = 100.0;
  p.integrator.time_step = 0.01;
  p.accuracy.estimate = false;
  const cloud::PointCloud ball = asCloud(makeSphere(700, 0.1).points);
  std::vector<std::uint64_t> hashes;
  for (const bool is_auto : {true, false}) {
    if (!is_auto) p.contact.self = false;
    Simulation s(p, ball);
    run(s, 20);
    hashes.push_back(s.stateHash());
    EXPECT_GT(s.statistics().max_stretch, 0.02);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

// Steps of 5 ms, 500 points: the upper half of a soft ball falls onto the lower one, which is held.
ContactScene dropHalfABall() {
  ContactScene scene;
  simulation::SceneParams& p = scene.params;
  p.material.young_modulus = 2e4;
  p.material.damping = 3.0;
  p.integrator.time_step = 0.005;
  p.duration = 1.0;
  p.accuracy.estimate = false;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(1.0, 1.0, -0.08);
  p.pins = {pin};
  scene.cloud = asCloud(makeSphere(500, 0.16).points);
  return scene;
}

TEST(SelfContactByDefault, ABallThatCollapsesDoesNotCrossItselfByDefault) {
  const SelfContactOutcome seen = simulate(dropHalfABall());
  EXPECT_EQ(seen.crossed, 0);
  EXPECT_GT(seen.touched, 10);
  ContactScene without = dropHalfABall();
  without.params.contact.self = false;
  EXPECT_GT(simulate(without).crossed, 10);
}

TEST(SelfContactByDefault, ATowelThatIsFoldedDoesNotCrossItselfByDefault) {
  ContactScene scene = makeScene("fold", 2, 1.0);
  scene.params.contact.self = {};
  const SelfContactOutcome seen = simulate(scene);
  EXPECT_EQ(seen.crossed, 0);
  EXPECT_GT(seen.touched, 10);
}

// Layers a third of a spacing apart are bridged by the model; contact cannot use the triangles that overlap.
TEST(SelfContactByDefault, WhatHasNoContactIsTold) {
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

// The upper half of a soft tube with a narrow slit falls through the lower one, which is held.
TEST(SelfContactByDefault, TellsOnceThatPartsHavePassedThroughEachOther) {
  simulation::SceneParams p = hangingSheet();
  p.material.young_modulus = 1e4;
  p.material.bending_rigidity = 1e-7;
  p.integrator.time_step = 0.015;
  p.duration = 0.3;
  p.accuracy.estimate = false;
  simulation::PinParams lower;
  lower.region.min = Vec3(-1.0, -1.0, -1.0);
  lower.region.max = Vec3(1.0, 2.0, 0.0);
  p.pins = {lower};
  const cloud::PointCloud tube = makeTube(5.6);
  const auto countTold = [](Simulation& s) {
    int told = 0;
    for (int k = 0; k < 20; ++k) told += s.step().notice.find("have come to pass through each other") != std::string::npos;
    return told;
  };
  Simulation s(p, tube);
  EXPECT_NE(whyOff(s).find("true switches it on"), std::string::npos) << whyOff(s);
  EXPECT_EQ(countTold(s), 1);
  EXPECT_EQ(countTold(s), 0);
  s.reset();
  EXPECT_EQ(countTold(s), 1);
  for (const bool is_on : {true, false}) {
    p.contact.self = is_on;
    Simulation chosen(p, tube);
    EXPECT_EQ(countTold(chosen), 0);
  }
}

// Triangles of the surface that overlap on a rough sheet: an edge of one passes through the other, with which it shares a vertex.
TEST(SelfContactByDefault, OfTrianglesThatPassThroughTheirNeighboursTheLargerHasNoContact) {
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

TEST(SelfContactByDefault, AThicknessOfSpacingsIsWarnedOf) {
  ContactScene scene = makeScene("drop", 1, 0.1);
  EXPECT_TRUE(Simulation(scene.params, scene.cloud).buildWarnings().empty());
  scene.params.contact.thickness = 0.08;
  const std::vector<std::string> warnings = Simulation(scene.params, scene.cloud).buildWarnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("contact.thickness is "), std::string::npos) << warnings[0];
}

TEST(SelfContactByDefault, AThicknessBeyondTheSurfaceIsRefused) {
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

}  // namespace
}  // namespace deformable_surface::test
