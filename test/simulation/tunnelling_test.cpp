// Solid tools that are thinner than their motion in a step, or faster than contact can follow, do not pass through a sheet.
#include "clouds.h"
#include "deformable_surface/simulation/contact_load.h"
#include "energy_rise.h"
#include "model/solids.h"
#include "support/meshes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace deformable_surface::test {
namespace {

using geometry::Solid;

/// A sheet of a square metre, held along its edges, without gravity. It is stretchy enough to be pushed far, and damped.
simulation::SceneParams heldSheet() {
  simulation::SceneParams p;
  p.material.damping = 20.0;
  p.material.bending_rigidity = 1e-4;
  p.gravity.setZero();
  for (const auto& [min, max] : {std::pair<Vec3, Vec3>{Vec3(-1, -1, -1), Vec3(0.001, 2, 1)},
                                 {Vec3(0.999, -1, -1), Vec3(2, 2, 1)},
                                 {Vec3(-1, -1, -1), Vec3(2, -0.499, 1)},
                                 {Vec3(-1, 0.499, -1), Vec3(2, 2, 1)}}) {
    simulation::PinParams pin;
    pin.region.min = min;
    pin.region.max = max;
    p.pins.push_back(pin);
  }
  p.simplification.target_points = 250;
  return p;
}

/// From below the middle of the sheet to above it at a speed, m/s. There it rests.
tool::ToolParams mover(const Solid& shape, double speed) {
  tool::ToolParams tool;
  tool.id = "mover";
  tool.shape = shape;
  const double from = -0.45, to = 0.15;
  tool.path = {{0.0, Vec3(0.5, 0.0, from)}, {(to - from) / speed, Vec3(0.5, 0.0, to)}};
  return tool;
}

std::vector<std::pair<std::string, Solid>> listSolids() {
  std::vector<std::pair<std::string, Solid>> solids(4);
  solids[0].first = "ball";
  solids[0].second.radius = 0.15;
  solids[1].first = "box";
  solids[1].second.kind = Solid::Kind::kBox;
  solids[1].second.size = Vec3(0.3, 0.3, 0.1);
  solids[2].first = "plate of a tenth of a millimetre";
  solids[2].second.kind = Solid::Kind::kBox;
  solids[2].second.size = Vec3(0.3, 0.3, 1e-4);
  solids[3].first = "mesh";
  solids[3].second.kind = Solid::Kind::kMesh;
  const Mesh mesh = makeBoxMesh(Vec3(0.3, 0.3, 0.02));
  geometry::setMesh(mesh.vertices, geometry::toRows(mesh.triangles), solids[3].second);
  return solids;
}

/// Height of the lowest of the free points over the inner half of the tool, above the tool's middle, m.
double findLowest(const simulation::Simulation& s, const Points& rest, double height) {
  double lowest = 1e300;
  for (std::size_t i = 0; i < rest.size(); ++i)
    if ((rest[i] - Vec3(0.5, 0.0, 0.0)).cwiseAbs().maxCoeff() < 0.075)
      lowest = std::min(lowest, s.state().positions[i].z() - height);
  return lowest;
}

TEST(Tunnelling, NoSolidGoesThroughASheetHoweverFastOrThin) {
  // A sub-step is about a millisecond. At one metre per second the plate passes in a tenth of one, at a hundred in a thousandth.
  for (const auto& [name, solid] : listSolids())
    for (double speed : {1.0, 100.0}) {
      simulation::SceneParams p = heldSheet();
      p.tools = {mover(solid, speed)};
      simulation::Simulation s(p, sheetCloud());
      const Points rest = s.state().positions;
      run(s, static_cast<int>(0.6 / speed / 0.01) + 120);
      EXPECT_GT(findLowest(s, rest, 0.15), -0.01) << name << " at " << speed << " m/s";
      const simulation::ToolReaction reaction = s.toolReactions()[0];
      EXPECT_LT(reaction.force.z(), -0.1) << name << " at " << speed << " m/s";
      // At rest the point with the largest load is as deep as its load over the penalty. A quarter of the spacing between points
      // bounds it.
      EXPECT_LT(reaction.penetration, 0.25 / std::sqrt(250.0)) << name << " at " << speed << " m/s";
    }
}

TEST(Tunnelling, ASheetThatFallsOnAThinPlateStaysOnIt) {
  simulation::SceneParams p = heldSheet();
  p.pins.clear();
  p.material.damping = 2.0;
  p.gravity = Vec3(0.0, 0.0, -9.81);
  tool::ToolParams plate;
  plate.id = "plate";
  plate.shape.kind = Solid::Kind::kBox;
  plate.shape.size = Vec3(3.0, 3.0, 1e-4);
  plate.path = {{0.0, Vec3(0.5, 0.0, -1.0)}};
  p.tools = {plate};
  simulation::Simulation s(p, sheetCloud());
  run(s, 100);
  for (const Vec3& x : s.state().positions) EXPECT_GT(x.z(), -1.01);
}

TEST(Tunnelling, ASlowToolTouchesAsIfNothingWereRemembered) {
  // Points that the solid pushes back by itself are left to it: none is recorded as crossed.
  simulation::SceneParams p = heldSheet();
  Solid ball;
  ball.radius = 0.15;
  p.tools = {mover(ball, 0.5)};
  simulation::Simulation s(p, sheetCloud());
  std::vector<double> masses = s.model().masses();
  simulation::ContactLoad load(masses);
  load.setTools(p.tools);
  load.setRate(100.0);
  const std::vector<char> held(masses.size(), 0);
  for (int k = 0; k < 120; ++k) {
    EXPECT_EQ(load.beginStep(s.time(), 0.01, s.state(), held), k == 0);  // which first tells what acts
    run(s, 1);
  }
  EXPECT_GT(s.toolReactions()[0].contacts, 0);
}

TEST(Tunnelling, ASnapshotHoldsWhatWasPassedOver) {
  simulation::SceneParams p = heldSheet();
  p.tools = {mover(listSolids()[2].second, 30.0)};
  simulation::Simulation s(p, sheetCloud());
  run(s, 2);
  const simulation::Snapshot snapshot = s.snapshot();
  run(s, 5);
  const std::uint64_t hash = s.stateHash();
  s.reset();
  s.restore(snapshot);
  run(s, 5);
  EXPECT_EQ(s.stateHash(), hash);
}

TEST(Tunnelling, ANeedleThatFindsItsWayBetweenThePointsIsReportedOnce) {
  simulation::SceneParams p = heldSheet();
  Solid needle;
  needle.radius = 1e-4;
  p.tools = {mover(needle, 1.0)};
  p.tools[0].path[0].position.head<2>() = p.tools[0].path[1].position.head<2>() = Vec2(0.513, 0.013);
  simulation::Simulation s(p, sheetCloud());
  int told = 0;
  for (int k = 0; k < 80; ++k) {
    const std::string notice = s.step().notice;
    if (notice.find("tool 'mover' has passed through the surface: it is narrower than the distance of the simulation points") !=
        std::string::npos)
      ++told;
  }
  EXPECT_EQ(told, 1);
}

// A ball of three spacings presses a soft sheet deeper and deeper, until it snaps over the ball.
TEST(Tunnelling, ABallOverWhichAStretchedSheetSnapsIsReportedOnce) {
  for (const solve::IntegratorType type : {solve::IntegratorType::kVerlet, solve::IntegratorType::kStatic})
    for (const double height : {0.1, 1.2}) {
      simulation::SceneParams p = heldSheet();
      p.integrator.type = type;
      p.integrator.time_step = type == solve::IntegratorType::kStatic ? 0.1 : 0.01;
      p.accuracy.estimate = false;
      Solid ball;
      ball.radius = 0.1;
      p.tools = {mover(ball, 1.0)};
      p.tools[0].path[1] = {1.6, Vec3(0.5, 0.0, height)};
      simulation::Simulation s(p, sheetCloud());
      int told = 0;
      while (s.time() < 1.75) told += s.step().notice.find("tool 'mover' has passed through the surface: ") != std::string::npos;
      EXPECT_EQ(told, height > 1.0 ? 1 : 0) << static_cast<int>(type) << ", up to " << height << " m";
    }
}

TEST(Tunnelling, AToolThatIsWiderThanTheDistanceOfPointsIsNotCalledNarrower) {
  simulation::SceneParams p = heldSheet();
  p.integrator.type = solve::IntegratorType::kStatic;
  p.integrator.time_step = 0.1;
  p.accuracy.estimate = false;
  Solid ball;
  ball.radius = 0.1;
  p.tools = {mover(ball, 1.0)};
  p.tools[0].path[1] = {1.6, Vec3(0.5, 0.0, 1.2)};
  simulation::Simulation s(p, sheetCloud());
  std::string notices;
  while (s.time() < 1.75) notices += s.step().notice;
  EXPECT_EQ(notices.find("narrower"), std::string::npos) << notices;
  EXPECT_NE(notices.find("contact did not hold how far the surface is stretched"), std::string::npos) << notices;
}

// How many notices tell that a tool has passed through the surface, in so many steps.
int countTold(simulation::Simulation& s, int steps) {
  int told = 0;
  for (int k = 0; k < steps; ++k) told += s.step().notice.find("has passed through the surface") != std::string::npos;
  return told;
}

/// All points are simulated, in rows 0.053 m apart, with no row in the middle.
simulation::SceneParams sheetOfRows() {
  simulation::SceneParams p = heldSheet();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.accuracy.estimate = false;
  return p;
}
cloud::PointCloud cloudOfRows() { return asCloud(makeSheet(20, 20, 1.0, 1.0, 0.0).points); }

// Between two rows, from below. Neither its middle nor an end of its longest axis comes through.
TEST(Tunnelling, AThinBladeWhoseEdgeComesFarThroughASheetIsReportedOnce) {
  for (const bool is_disc : {false, true})
    for (const double way : {-0.05, 0.04, 0.15}) {
      simulation::SceneParams p = sheetOfRows();
      Solid blade;
      blade.kind = is_disc ? Solid::Kind::kCylinder : Solid::Kind::kBox;
      blade.size = Vec3(0.5, 0.002, 0.4);
      blade.radius = 0.2;
      blade.height = 0.002;
      p.tools = {mover(blade, 1.0)};
      const Vec4 on_edge = is_disc ? Vec4(std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)) : Vec4(0.0, 0.0, 0.0, 1.0);
      p.tools[0].path = {{0.0, Vec3(0.5, 0.0, -0.3), on_edge}, {0.3, Vec3(0.5, 0.0, -0.2 + way), on_edge}};
      simulation::Simulation s(p, cloudOfRows());
      EXPECT_EQ(countTold(s, 60), way > 0.1 ? 1 : 0) << "disc: " << is_disc << ", way: " << way << " m";
    }
}

// Coarse sheets are cut by the edges of what they lie on. Upright, the plate holds the sheet by its upper edge.
TEST(Tunnelling, ASheetThatLiesOnAThinPlateAndHangsOverItsEdgesIsNotPassed) {
  struct Case {
    bool is_upright;
    double thickness, jitter;  // m; of the cloud
  };
  for (const Case& c : {Case{false, 0.002, 0.0}, {false, 0.002, 0.2}, {false, 0.02, 0.2}, {true, 0.02, 0.2}}) {
    simulation::SceneParams p = sheetOfRows();
    p.pins.clear();
    p.material.damping = 2.0;
    p.gravity = Vec3(0.0, 0.0, -9.81);
    tool::ToolParams plate;
    plate.id = "plate";
    plate.friction = 0.5;
    plate.shape.kind = Solid::Kind::kBox;
    plate.shape.size = Vec3(0.5, 0.4, c.thickness);
    const Vec4 upright(std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)), level(0.0, 0.0, 0.0, 1.0);
    plate.path = {{0.0, Vec3(0.5, 0.01, c.is_upright ? -0.25 : -0.05), c.is_upright ? upright : level}};
    p.tools = {plate};
    if (c.is_upright) p.simplification.method = cloud::SimplificationMethod::kDelaunay;
    p.simplification.target_points = 400;
    simulation::Simulation s(p, asCloud(makeSheet(c.is_upright ? 60 : 20, c.is_upright ? 60 : 20, 1.0, 1.0, c.jitter).points));
    EXPECT_EQ(countTold(s, 70), 0) << "upright: " << c.is_upright << ", " << c.thickness << " m, jitter " << c.jitter;
    EXPECT_GT(s.toolReactions()[0].contacts, 0);
  }
}

// A sheet of 0.2 m on a table without friction, and a box, 0.02 m thick, whose lower face is 0.02 mm below the table.
simulation::SceneParams lyingSheet(const Vec3& size, const std::vector<std::pair<double, double>>& course) {
  simulation::SceneParams p;
  p.material.young_modulus = 1e5;
  p.material.thickness = 0.001;
  p.material.density = 300.0;
  p.material.damping = 3.0;
  p.material.bending_rigidity = 1e-5;
  p.accuracy.estimate = false;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.tools.resize(2);
  p.tools[0].id = "table";
  p.tools[0].shape.kind = Solid::Kind::kPlane;
  p.tools[0].path = {{0.0, Vec3::Zero()}};
  p.tools[1].id = "box";
  p.tools[1].shape.kind = Solid::Kind::kBox;
  p.tools[1].shape.size = size;
  for (const auto& [time, x] : course) p.tools[1].path.push_back({time, Vec3(x, 0.0, 0.00998)});
  return p;
}
cloud::PointCloud lyingCloud() { return asCloud(makeSheet(20, 20, 0.2, 0.2, 0.0).points); }

// The sheet is drawn along below a pad that presses on it.
TEST(Tunnelling, AFlatFaceLetsASheetRunInBelowItPastItsSides) {
  simulation::SceneParams p = lyingSheet(Vec3(0.05, 0.05, 0.02), {{0.0, 0.1}});
  p.tools[1].path[0].position.z() = 0.012;
  p.tools[1].path.push_back({0.1, Vec3(0.1, 0.0, 0.00998)});
  p.pins.resize(1);
  p.pins[0].region.min = Vec3(-1.0, -1.0, -1.0);
  p.pins[0].region.max = Vec3(0.02, 1.0, 1.0);
  p.pins[0].path = {{0.15, Vec3::Zero()}, {0.5, Vec3(-0.03, 0.0, 0.0)}};
  simulation::Simulation s(p, lyingCloud());
  while (s.time() < 0.5) ASSERT_TRUE(s.step().ok);
  const simulation::ToolReaction pad = s.toolReactions()[1];
  EXPECT_GT(pad.force.z(), 0.01);
  EXPECT_LT(std::abs(pad.force.x()), 0.1 * pad.force.z());
  for (const simulation::Contact& contact : s.contacts())
    if (contact.tool == 1) EXPECT_LT(contact.normal.z(), -0.9) << contact.position.transpose();
}

// No point of it is below the box before.
TEST(Tunnelling, TheSideOfABoxPushesALyingSheetByItsEdge) {
  for (const double speed : {0.1, 1.0}) {
    simulation::Simulation s(lyingSheet(Vec3(0.1, 0.3, 0.02), {{0.0, 0.26}, {0.11 / speed, 0.15}}), lyingCloud());
    while (s.time() < 0.11 / speed) ASSERT_TRUE(s.step().ok);
    double farthest = 0.0;
    for (const Vec3& point : s.state().positions) farthest = std::max(farthest, point.x());
    EXPECT_LT(farthest, 0.1 + 0.002) << speed << " m/s";
  }
}

// How many notices tell that this tool has passed through a block of elastic solid, 0.2 m x 0.2 m x 0.1 m, held at its lower
// side.
int countPassages(const tool::ToolParams& tool, bool touches_places = true) {
  simulation::SceneParams p;
  if (!touches_places) p.contact.cloud_points = 0;
  p.model = "elastic_solid";
  p.material.young_modulus = 2e4;
  p.material.damping = 5.0;
  p.gravity.setZero();
  p.accuracy.estimate = false;
  p.integrator.time_step = 0.005;
  p.pins.resize(1);
  p.pins[0].region.max = Vec3(1.0, 1.0, 0.001);
  p.pins[0].region.min = Vec3(-1.0, -1.0, -1.0);
  p.tools = {tool};
  cloud::PointCloud block;
  block.positions = makeBox(11, 11, 6, 0.02, 0.1);
  simulation::Simulation s(p, block);
  int told = 0;
  for (int k = 0; k < 120; ++k) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
    if (!outcome.ok) break;
    told += outcome.notice.find("tool 'tip' has passed through the surface, between the points of the body") != std::string::npos;
  }
  return told;
}

// Pressed less deep, or with places on the skin, it dents the body. A ball smaller than the spacing comes in between the places.
TEST(Tunnelling, ABallThatComesIntoABodyIsReportedOnce) {
  struct Case {
    double radius, end;  // m, of the ball's middle
    bool touches_places;
    int told;
  };
  for (const Case& c : {Case{0.03, 0.05, true, 0}, {0.03, 0.05, false, 1}, {0.03, 0.1, false, 0}, {0.006, 0.05, true, 1}}) {
    tool::ToolParams ball;
    ball.id = "tip";
    ball.shape.radius = c.radius;
    const Vec3 start(0.1, 0.1, 0.1 + c.radius);
    ball.path = {{0.0, start, Vec4(0.0, 0.0, 0.0, 1.0)}, {0.5, Vec3(0.1, 0.1, c.end), Vec4(0.0, 0.0, 0.0, 1.0)}};
    EXPECT_EQ(countPassages(ball, c.touches_places), c.told) << c.radius << " m, down to " << c.end;
  }
}

// Their middles stay outside. A stump, a cone that does not go deep, and one that touches places on the skin dent the body.
TEST(Tunnelling, TipsOfNeedlesAndConesThatComeIntoABodyAreReportedOnce) {
  struct Case {
    Solid::Kind kind;
    double radius, height, end;  // m, of the tip
    bool touches_places;
    int told;
  };
  for (const Case& c :
       {Case{Solid::Kind::kCylinder, 0.006, 0.3, 0.05, true, 1}, Case{Solid::Kind::kCone, 0.04, 0.16, 0.04, false, 1},
        Case{Solid::Kind::kCone, 0.04, 0.16, 0.04, true, 0}, Case{Solid::Kind::kCylinder, 0.04, 0.1, 0.09, true, 0},
        Case{Solid::Kind::kCone, 0.04, 0.16, 0.095, false, 0}}) {
    tool::ToolParams tool;
    tool.id = "tip";
    tool.shape.kind = c.kind;
    tool.shape.radius = c.radius;
    tool.shape.height = c.height;
    const Vec4 over(1.0, 0.0, 0.0, 0.0);
    const auto atHeight = [&](double tip) { return Vec3(0.103, 0.104, tip + 0.5 * c.height); };
    tool.path = {{0.0, atHeight(0.105), over}, {0.5, atHeight(c.end), over}};
    EXPECT_EQ(countPassages(tool, c.touches_places), c.told) << c.radius << " m, tip at " << c.end;
  }
}

// Points that come in by a side of the box and come out over its edge, and points between that are chosen there. Nothing damps.
TEST(Tunnelling, ASheetThatSlidesOverEdgesGainsNoEnergy) {
  for (const auto& [across, target, cloud_points] :
       {std::array{30, 120, 0}, {30, 120, 8}, {30, 300, 8}, {20, 400, 0}, {20, 400, 8}}) {
    simulation::SceneParams p = heldSheet();
    p.pins.clear();
    p.gravity = Vec3(0.0, 0.0, -9.81);
    p.material.damping = 0.0;
    p.material.young_modulus = 2e4;
    p.simplification.target_points = target;
    p.contact.cloud_points = cloud_points;
    p.contact.self = false;
    p.accuracy.estimate = false;
    p.sleep.mode = simulation::Sleep::kNever;
    tool::ToolParams box;
    box.id = "box";
    box.shape.kind = Solid::Kind::kBox;
    box.shape.size = Vec3(0.4, 0.5, 0.1);
    box.path = {{0.0, Vec3(0.5, 0.0, -0.06)}};
    p.tools = {box};
    simulation::Simulation s(p, asCloud(makeSheet(across, across, 1.0, 1.0, 0.0).points));
    EnergyRise energy(s);
    for (int k = 0; k < 150; ++k) {
      ASSERT_TRUE(s.step().ok);
      energy.look(s);
    }
    EXPECT_GT(energy.fastest(), 0.5);
    EXPECT_LT(energy.rise(), 0.04 * energy.fastest()) << s.state().size() << " of " << across << " across, " << cloud_points;
  }
}

}  // namespace
}  // namespace deformable_surface::test
