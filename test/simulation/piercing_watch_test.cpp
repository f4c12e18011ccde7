// Tools that go through a surface of particles, or tear it open, are told with the width that would have held; with that width
// none does.
#include "../../src/simulation/models/oriented_particles/piercing_watch.h"

#include "clouds.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/expectations.h"
#include "particles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr double kRadius = 0.5;  // m, of the sphere

tool::ToolParams ball(const std::string& id, double radius, const Vec3& from, const Vec3& to, double time) {
  const Vec4 unturned(0.0, 0.0, 0.0, 1.0);
  tool::ToolParams tool;
  tool.id = id;
  tool.shape.radius = radius;
  tool.path = {{0.0, from, unturned}, {time, to, unturned}};
  return tool;
}

// As scenes/particles_torus.yaml. stiffness: the bending rigidity in E h a^2. radius: of the balls, m.
SceneParams makeTorusScene(Index points, double jitter, double stiffness, double radius) {
  SceneParams p;
  p.model = "oriented_particles";
  p.cloud.shape = simulation::CloudParams::Shape::kSphere;
  p.cloud.points = points;
  p.cloud.radius = kRadius;
  p.cloud.jitter = jitter;
  p.cloud.seed = 5;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.gravity.setZero();
  p.material.young_modulus = 1e5;
  p.material.thickness = 1e-3;
  p.material.density = 1000.0;
  p.material.damping = 25.0;
  const double squared_spacing = 2.0 / std::sqrt(3.0) * 4.0 * kPi * kRadius * kRadius / points;
  p.material.bending_rigidity = stiffness * p.material.young_modulus * p.material.thickness * squared_spacing;
  p.oriented_particles.rest_shape = model::RestShape::kFlat;
  p.oriented_particles.delete_trapped = p.oriented_particles.stretching = true;
  p.oriented_particles.growing = model::Growing::kGaps;
  p.oriented_particles.growth_interval = 0.01;
  p.oriented_particles.growth.min_gap = 1.6;
  p.oriented_particles.growth.max_gap = 2.5;
  const double far = kRadius + 0.05 + radius;
  p.tools = {ball("above", radius, Vec3(0.0, 0.0, far), Vec3(0.0, 0.0, radius), 2.0),
             ball("below", radius, Vec3(0.0, 0.0, -far), Vec3(0.0, 0.0, -radius), 2.0)};
  return p;
}

// All notices of a run, m and s.
std::string runAll(Simulation& s, double time) {
  std::string notices;
  while (s.time() < time) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
    if (!outcome.ok) break;
    notices += outcome.notice + "\n";
  }
  return notices;
}

std::size_t countOf(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(PiercingWatch, ABallThatIsTooNarrowIsToldOnceWithTheWidthThatHolds) {
  const SceneParams p = makeTorusScene(500, 0.0, 0.06, 0.2 * kRadius);
  Simulation s(p, io::makeShape(p.cloud));
  const std::string notices = runAll(s, 2.4);
  EXPECT_EQ(countOf(notices, "has gone through the surface"), 2) << notices;
  EXPECT_EQ(countOf(notices, "tool 'above', 0.2 m wide, has gone through"), 1) << notices;
  EXPECT_EQ(countOf(notices, "at least 0.34 m wide"), 2) << notices;  // four spacings of 0.085 m
}

TEST(PiercingWatch, StiffSurfacesNeedWiderTools) {
  const SceneParams p = makeTorusScene(500, 0.3, 0.14, 0.2 * kRadius);
  Simulation s(p, io::makeShape(p.cloud));
  EXPECT_GE(countOf(runAll(s, 2.4), "at least 0.51 m wide"), 1);
}

// Of a stiff surface, and of few particles, that part before the balls and do not bind again.
TEST(PiercingWatch, ABallThatTearsTheSurfaceOpenIsToldWithTheWidthThatHolds) {
  struct Case {
    Index points;
    double stiffness, ball;
    const char* width;
  };
  for (const Case& c : {Case{1200, 0.14, 0.2, "at least 0.329 m wide"}, Case{300, 0.06, 0.25, "at least 0.439 m wide"}}) {
    const SceneParams p = makeTorusScene(c.points, 0.0, c.stiffness, c.ball * kRadius);
    Simulation s(p, io::makeShape(p.cloud));
    const std::string notices = runAll(s, 2.4);
    EXPECT_GT(simulation::computeQuantity("boundary_loops", s), 0.0);
    EXPECT_GE(countOf(notices, "has torn the surface open"), 1) << notices;
    EXPECT_LE(countOf(notices, "has torn the surface open"), 2) << notices;
    EXPECT_GE(countOf(notices, c.width), 1) << notices;
  }
}

// From 5 % more than the least width on.
TEST(PiercingWatch, BallsOfTheLeastWidthTurnASphereIntoATorus) {
  struct Case {
    Index points;
    double jitter, stiffness, ball;
  };
  for (const Case& c : {Case{700, 0.3, 0.06, 0.3}, Case{1000, 0.0, 0.1, 0.32}}) {
    const SceneParams p = makeTorusScene(c.points, c.jitter, c.stiffness, c.ball * kRadius);
    Simulation s(p, io::makeShape(p.cloud));
    const std::string notices = runAll(s, 3.4);
    EXPECT_EQ(countOf(notices, "gone through"), 0) << notices;
    EXPECT_EQ(countOf(notices, "torn"), 0) << notices;
    EXPECT_EQ(simulation::computeQuantity("components", s), 1.0) << c.points;
    EXPECT_EQ(simulation::computeQuantity("boundary_loops", s), 0.0) << c.points;
    EXPECT_EQ(simulation::computeQuantity("euler_characteristic", s), 0.0) << c.points;
  }
}

SceneParams makeSheetScene() {
  SceneParams p;
  p.model = "oriented_particles";
  p.cloud.shape = simulation::CloudParams::Shape::kLattice;
  p.cloud.points = 100;
  p.cloud.size = Vec2(0.5, 0.5);
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.gravity.setZero();
  p.material.damping = 25.0;
  p.material.bending_rigidity = 1.0;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(-0.1, 1.0, 1.0);
  p.pins = {pin};
  return p;
}

// A ball presses on a sheet from below, is taken away, and one of the same name presses from above.
TEST(PiercingWatch, ABallThatIsPutOnTheOtherSideIsNotTold) {
  Simulation s(makeSheetScene(), io::makeShape(makeSheetScene().cloud));
  std::string notices;
  for (const double side : {-1.0, 1.0}) {
    s.setTool(ball("ball", 0.05, Vec3(0.0, 0.0, side * 0.045), Vec3(0.0, 0.0, side * 0.045), 0.1));
    notices += runAll(s, s.time() + 0.3);
    EXPECT_GT(simulation::computeQuantity("touching", s), 0.0);
  }
  EXPECT_EQ(countOf(notices, "gone through"), 0) << notices;
}

// The edges of a sheet that a tool presses on, also beyond them, are those of the sheet.
TEST(PiercingWatch, ATableThatASheetLiesOnIsNotTold) {
  SceneParams p = makeSheetScene();
  p.gravity = Vec3(0.0, 0.0, -9.81);
  p.pins.clear();
  tool::ToolParams table = ball("table", 0.0, Vec3(0.2, 0.0, -0.1), Vec3(0.2, 0.0, -0.1), 1.0);
  table.shape.kind = geometry::Solid::Kind::kBox;
  table.shape.size = Vec3(0.5, 1.0, 0.2);
  p.tools = {table};
  Simulation s(p, io::makeShape(p.cloud));
  const std::string notices = runAll(s, 1.0);
  EXPECT_GT(simulation::computeQuantity("touching", s), 0.0);
  EXPECT_EQ(countOf(notices, "torn"), 0) << notices;
}

// A small ball presses on a sheet from above, goes around its edge and presses from below.
TEST(PiercingWatch, ABallThatGoesAroundTheEdgeIsNotTold) {
  SceneParams p = makeSheetScene();
  const Vec4 unturned(0.0, 0.0, 0.0, 1.0);
  tool::ToolParams tool = ball("ball", 0.05, Vec3(0.0, 0.0, 0.1), Vec3(0.0, 0.0, 0.045), 0.1);
  for (const auto& [time, place] :
       {std::pair(0.2, Vec3(0.0, 0.0, 0.2)), std::pair(0.4, Vec3(0.5, 0.0, 0.2)), std::pair(0.6, Vec3(0.5, 0.0, -0.2)),
        std::pair(0.8, Vec3(0.0, 0.0, -0.2)), std::pair(1.0, Vec3(0.0, 0.0, -0.045))})
    tool.path.push_back({time, place, unturned});
  p.tools = {tool};
  Simulation s(p, io::makeShape(p.cloud));
  bool has_touched_above = false, has_touched_below = false;
  std::string notices;
  while (s.time() < 1.0) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
    notices += outcome.notice;
    if (simulation::computeQuantity("touching", s) == 0.0) continue;
    (s.time() < 0.3 ? has_touched_above : has_touched_below) = true;
  }
  EXPECT_TRUE(has_touched_above && has_touched_below);
  EXPECT_EQ(countOf(notices, "gone through"), 0) << notices;
  EXPECT_EQ(countOf(notices, "torn"), 0) << notices;
}

// Between two looks it moves by more than its width, and by less than a spacing.
TEST(PiercingWatch, ANeedleThatGoesThroughIsTold) {
  SceneParams p = makeSheetScene();
  p.gravity.setZero();
  p.tools = {ball("needle", 0.005, Vec3(0.03, 0.02, 0.3), Vec3(0.03, 0.02, -0.1), 0.5)};
  p.tools[0].shape.kind = geometry::Solid::Kind::kCylinder;
  p.tools[0].shape.height = 0.4;
  Simulation s(p, io::makeShape(p.cloud));
  const std::string notices = runAll(s, 0.6);
  EXPECT_EQ(countOf(notices, "tool 'needle', 0.01 m wide, has gone through"), 1) << notices;
}

// Its middle stays above the sheet.
TEST(PiercingWatch, ANeedleWhoseTipGoesThroughIsTold) {
  SceneParams p = makeSheetScene();
  p.tools = {ball("needle", 0.005, Vec3(0.03, 0.02, 0.3), Vec3(0.03, 0.02, 0.1), 0.5)};
  p.tools[0].shape.kind = geometry::Solid::Kind::kCylinder;
  p.tools[0].shape.height = 0.4;
  Simulation s(p, io::makeShape(p.cloud));
  const std::string notices = runAll(s, 0.6);
  EXPECT_EQ(countOf(notices, "tool 'needle', 0.01 m wide, has gone through"), 1) << notices;
}

// A sheet that is held at two edges. A ball presses on it slowly, as wide as a deep dent holds: at a free edge, which slips off
// it in the end, and in the middle.
TEST(PiercingWatch, ABallThatAnEdgeSlipsOffIsNotTold) {
  struct Case {
    double place, end;
    bool is_through;
  };
  for (const Case& c : {Case{0.45, 2.0, false}, Case{0.42, 2.0, false}, Case{-0.48, 2.0, false}, Case{0.0, 0.5, true}}) {
    SceneParams p = makeSheetScene();
    p.cloud.points = 800;
    p.cloud.size = Vec2(1.0, 1.0);
    p.gravity.setZero();
    p.material.young_modulus = 1e5;
    p.material.thickness = 1e-3;
    p.material.density = 1000.0;
    p.material.damping = 5.0;
    p.material.bending_rigidity = 0.012;
    simulation::PinParams left, right;
    left.region.min = right.region.min = Vec3::Constant(-1.0);
    left.region.max = right.region.max = Vec3::Constant(1.0);
    left.region.max.x() = -0.46;
    right.region.min.x() = 0.46;
    p.pins = {left, right};
    p.tools = {ball("ball", 0.1, Vec3(0.0, c.place, 0.12), Vec3(0.0, c.place, -0.3), c.end)};
    Simulation s(p, io::makeShape(p.cloud));
    const std::string notices = runAll(s, c.end + 0.1);
    EXPECT_EQ(countOf(notices, "gone through"), c.is_through ? 1 : 0) << c.place << notices;
    // Nothing holds it any more.
    EXPECT_EQ(simulation::computeQuantity("touching", s), 0.0) << c.place;
  }
}

// With kept bonds: a ball that is pushed into a held sheet fast breaks some, a slow one none.
TEST(PiercingWatch, ABallThatBreaksKeptBondsIsToldOnce) {
  for (const bool is_fast : {true, false}) {
    SceneParams p = makeSheetScene();
    p.cloud.points = 500;
    p.cloud.size = Vec2(1.0, 1.0);
    p.oriented_particles.bonds = model::ParticleBonds::kKept;
    p.material.young_modulus = 1e5;
    p.material.thickness = 1e-3;
    p.material.density = 1000.0;
    p.material.damping = 5.0;
    p.material.bending_rigidity = 1e-3;
    p.accuracy.estimate = false;
    p.integrator.time_step = 0.005;
    p.pins[0].region.min = Vec3(-0.44, -0.44, -1.0);
    p.pins[0].region.max = Vec3(0.44, 0.44, 1.0);
    p.pins[0].region.outside = true;
    const double end = is_fast ? 0.13 : 1.3;
    p.tools = {ball("ball", 0.072, Vec3(0.01, 0.013, 0.087), Vec3(0.01, 0.013, -0.178), end)};
    Simulation s(p, io::makeShape(p.cloud));
    const std::string notices = runAll(s, end + 0.3);
    EXPECT_EQ(simulation::computeQuantity("boundary_loops", s), is_fast ? 2.0 : 1.0);
    EXPECT_EQ(countOf(notices, "tool 'ball', 0.144 m wide, has torn the surface open: kept bonds"), is_fast ? 1 : 0) << notices;
  }
}

// A level sheet of particles, 0.1 m apart.
model::State makeSheet() {
  model::State state;
  for (int i = -10; i <= 10; ++i)
    for (int j = -10; j <= 10; ++j) state.positions.emplace_back(0.1 * i, 0.1 * j, 0.0);
  state.orientations.assign(state.positions.size(), Quaternion::Identity());
  state.traits.resize(state.positions.size());
  for (model::ParticleTraits& particle : state.traits) particle.id = state.next_id++;
  return state;
}

tool::ToolParams ballAt(double height) { return ball("ball", 0.3, Vec3(0.0, 0.0, height), Vec3(0.0, 0.0, height), 1.0); }

TEST(PiercingWatch, ABallThatHasGoneThroughIsWatchedNoMore) {
  const model::State sheet = makeSheet();
  simulation::PiercingWatch watch;
  int num_looks = 0;
  const auto allAround = [&](std::vector<char>& is_open) {
    std::fill(is_open.begin(), is_open.end(), 0);
    ++num_looks;
  };
  for (const double height : {0.3, 0.12, -0.12}) {
    const auto found = watch.look(0.0, {ballAt(height)}, sheet, 0.1, allAround);
    EXPECT_EQ(found.size(), height < 0.0 ? 1u : 0u) << height;
  }
  EXPECT_EQ(num_looks, 3);
  EXPECT_TRUE(watch.look(0.0, {ballAt(0.12)}, sheet, 0.1, allAround).empty());
  EXPECT_EQ(num_looks, 3);
  watch.reset();
  watch.look(0.0, {ballAt(0.12)}, sheet, 0.1, allAround);
  EXPECT_EQ(num_looks, 4);
}

// What the particles at it were like is of no use once it comes back.
TEST(PiercingWatch, ABallThatIsTakenAwayIsForgotten) {
  const model::State sheet = makeSheet();
  for (const bool is_taken_away : {false, true}) {
    simulation::PiercingWatch watch;
    watch.look(0.0, {ballAt(0.3)}, sheet, 0.1, [](std::vector<char>& is_open) { std::fill(is_open.begin(), is_open.end(), 0); });
    if (is_taken_away) watch.look(0.0, {}, sheet, 0.1, [](std::vector<char>&) {});
    std::size_t torn = 0;
    for (int k = 0; k < 20; ++k) torn += watch.look(0.0, {ballAt(0.3)}, sheet, 0.1, [](std::vector<char>&) {}).size();
    EXPECT_EQ(torn, is_taken_away ? 0u : 1u);
  }
}

}  // namespace
}  // namespace deformable_surface::test
