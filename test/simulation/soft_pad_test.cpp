// Contact that yields by a stated compliance: depth over pressure.
#include "../../src/simulation/contact_areas.h"
#include "clouds.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/io/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using Type = solve::IntegratorType;

constexpr double kGravity = 9.81;

tool::ToolParams makePad(double top, double friction, double slope = 0.0) {
  tool::ToolParams pad;
  pad.id = "pad";
  pad.friction = friction;
  pad.shape.kind = geometry::Solid::Kind::kBox;
  pad.shape.size = Vec3(4.0, 4.0, 1.0);
  pad.path.resize(1);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(slope, Vec3::UnitY()));
  pad.path[0].orientation = turn.coeffs();
  pad.path[0].position = Vec3(0.0, 0.0, top) - turn * Vec3(0.0, 0.0, 0.5);
  return pad;
}

SceneParams makeScene(Type type, double jitter) {
  SceneParams scene;
  scene.cloud.jitter = jitter;
  scene.integrator.type = type;
  scene.integrator.time_step = 0.01;
  scene.material.damping = 20.0;
  scene.accuracy.estimate = false;
  return scene;
}

Simulation makeSimulation(const SceneParams& scene) { return Simulation(scene, io::makeShape(scene.cloud)); }

// A sheet, of which every fourth point is simulated, that lies on the pad with its weight.
SceneParams makeSheetScene(Type type, Index points, double jitter) {
  SceneParams scene = makeScene(type, jitter);
  scene.cloud.shape = simulation::CloudParams::Shape::kSheet;
  scene.cloud.points = 4 * points;
  scene.cloud.size = Vec2(0.5, 0.5);
  scene.simplification.target_points = points;
  scene.material.thickness = 0.001;
  scene.material.density = 500.0;
  scene.tools = {makePad(-1e-4, 0.3)};
  return scene;
}
constexpr double kSheetPressure = 0.5 * kGravity;

// A block, 0.1 m high.
SceneParams makeBlockScene(Type type, Index points, double jitter) {
  SceneParams scene = makeScene(type, jitter);
  scene.model = "elastic_solid";
  scene.cloud.shape = simulation::CloudParams::Shape::kBar;
  scene.cloud.points = points;
  scene.cloud.size = Vec2(0.2, 0.1);
  scene.cloud.height = 0.1;
  scene.material.young_modulus = 1e6;
  scene.material.poisson_ratio = 0.3;
  scene.simplification.method = cloud::SimplificationMethod::kNone;
  scene.tools = {makePad(-0.05 - 1e-4, 0.0)};
  return scene;
}
constexpr double kBlockPressure = 0.1 * 1000.0 * kGravity;

// Mean depth below a height of the cloud's points that are lowest at rest, m.
double measureDepth(Simulation s, double top, int steps) {
  const Points rest = s.input().positions;
  double lowest = rest[0].z(), sum = 0.0, number = 0.0;
  for (const Vec3& p : rest) lowest = std::min(lowest, p.z());
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << outcome.problem;
  }
  const Points& now = s.surface(false).positions;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (rest[i].z() > lowest + 1e-9) continue;
    // Points at edges and corners of a block stand for less.
    const double share = s.model().masses().size() == rest.size() ? s.model().masses()[i] : 1.0;
    sum += share * (top - now[i].z());
    number += share;
  }
  return sum / number;
}

TEST(SoftPad, YieldsByComplianceTimesPressureUnderASheet) {
  for (const Type type : {Type::kVerlet, Type::kImplicit, Type::kStatic})
    for (const auto& [points, jitter, tolerance] : {std::tuple(225, 0.0, 0.05), {225, 0.3, 0.02}, {400, 0.2, 0.02}}) {
      SceneParams scene = makeSheetScene(type, points, jitter);
      scene.contact.compliance = 3e-3 / kSheetPressure;
      const double depth = measureDepth(makeSimulation(scene), -1e-4, type == Type::kStatic ? 1 : 100);
      EXPECT_NEAR(depth, 3e-3, tolerance * 3e-3) << points << " " << jitter;
    }
}

TEST(SoftPad, YieldsByComplianceTimesPressureUnderABlock) {
  for (const Type type : {Type::kVerlet, Type::kImplicit, Type::kStatic})
    for (const auto& [points, jitter] : {std::pair(225, 0.0), {225, 0.3}, {400, 0.2}}) {
      SceneParams scene = makeBlockScene(type, points, jitter);
      scene.contact.compliance = 2e-3 / kBlockPressure;
      const double depth = measureDepth(makeSimulation(scene), -0.05 - 1e-4, type == Type::kStatic ? 1 : 100);
      EXPECT_NEAR(depth, 2e-3, 0.03 * 2e-3) << points << " " << jitter;
    }
}

// In equilibria the depth of the penalty is taken back, so that pads may be harder than it.
TEST(SoftPad, MayBeHarderThanThePenaltyInEquilibria) {
  SceneParams scene = makeBlockScene(Type::kStatic, 225, 0.2);
  scene.contact.compliance = 5e-6 / kBlockPressure;
  EXPECT_NEAR(measureDepth(makeSimulation(scene), -0.05 - 1e-4, 1), 5e-6, 0.05 * 5e-6);
  scene.contact.compliance = 0.0;
  EXPECT_LT(measureDepth(makeSimulation(scene), -0.05 - 1e-4, 1), 1e-6);
}

// Two layers of which the lower one is pinned. They are apart at rest.
TEST(SoftPad, YieldsBetweenLayers) {
  for (const Type type : {Type::kVerlet, Type::kImplicit}) {
    SceneParams scene = makeScene(type, 0.2);
    scene.simplification.method = cloud::SimplificationMethod::kNone;
    scene.material.thickness = 0.001;
    scene.material.density = 500.0;
    scene.contact.self = true;
    scene.contact.thickness = 0.002;
    scene.contact.compliance = 2e-4 / kSheetPressure;
    const Surface lower = makeSheet(21, 21, 0.5, 0.5, 0.2, 1), upper = makeSheet(18, 18, 0.4, 0.4, 0.2, 2);
    cloud::PointCloud cloud;
    cloud.positions = lower.points;
    const Index n = cloud.size();
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : lower.points) middle += p / static_cast<double>(n);
    for (const Vec3& p : upper.points) middle -= p / static_cast<double>(upper.points.size());
    for (const Vec3& p : upper.points) cloud.positions.push_back(p + middle + Vec3(0.0, 0.0, 0.1));
    simulation::PinParams pin;
    pin.region.min = Vec3(-9.0, -9.0, -0.05);
    pin.region.max = Vec3(9.0, 9.0, 0.05);
    scene.pins.push_back(pin);
    Simulation s(scene, cloud);
    model::State state = s.state();
    for (Index i = n; i < state.size(); ++i) state.positions[i].z() = 0.00185;
    s.setState(state);
    for (int k = 0; k < 80; ++k) ASSERT_TRUE(s.step().ok);
    double depth = 0.0, mass = 0.0;
    for (Index i = n; i < state.size(); ++i) {
      depth += s.model().masses()[i] * (0.002 - s.state().positions[i].z());
      mass += s.model().masses()[i];
    }
    EXPECT_NEAR(depth / mass, 2e-4, 0.08 * 2e-4);  // too shallow by 5 to 6 %: thickness is 0.08 spacings
  }
}

TEST(SoftPad, FrictionHoldsAndSlidesAsWithoutIt) {
  for (const auto& [slope, holds] : {std::pair(0.9, true), {1.1, false}}) {
    const double angle = slope * std::atan(0.3);
    SceneParams scene = makeSheetScene(Type::kVerlet, 144, 0.2);
    scene.contact.compliance = 1e-3 / kSheetPressure;
    scene.tools.clear();
    scene.gravity = kGravity * Vec3(std::sin(angle), 0.0, -std::cos(angle));
    scene.tools = {makePad(-1e-4, 0.3)};
    Simulation s = makeSimulation(scene);
    for (int k = 0; k < 100; ++k) ASSERT_TRUE(s.step().ok);
    const Points before = s.state().positions;
    for (int k = 0; k < 50; ++k) ASSERT_TRUE(s.step().ok);
    double way = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) way = std::max(way, (s.state().positions[i] - before[i]).norm());
    EXPECT_EQ(way < 1e-6, holds) << way;
    EXPECT_TRUE(holds || way > 1e-3) << way;
  }
}

TEST(SoftPad, MakesNoEnergy) {
  for (const std::string model : {"mass_spring", "elastic_solid"}) {
    SceneParams scene =
        model == "mass_spring" ? makeSheetScene(Type::kVerlet, 200, 0.2) : makeBlockScene(Type::kVerlet, 225, 0.2);
    scene.material.damping = 0.0;
    scene.tools = {makePad(model == "mass_spring" ? -0.05 : -0.1, 0.0)};
    scene.contact.compliance = 3e-3 / (model == "mass_spring" ? kSheetPressure : kBlockPressure);
    Simulation s = makeSimulation(scene);
    double first = 0.0, largest = 0.0, moved = 0.0;
    for (int k = 0; k < 40; ++k) {
      ASSERT_TRUE(s.step().ok);
      const simulation::Statistics now = s.statistics();
      const double sum = now.kinetic_energy + now.elastic_energy + now.potential_energy;
      if (k == 0) first = sum;
      largest = std::max(largest, sum);
      moved = std::max(moved, now.kinetic_energy);
    }
    EXPECT_LT(largest - first, 5e-3 * moved) << model;
  }
}

TEST(SoftPad, GivesTheSameBitsForThreadsAndFromASnapshot) {
  SceneParams scene = makeSheetScene(Type::kVerlet, 300, 0.2);
  scene.contact.compliance = 3e-3 / kSheetPressure;
  std::vector<Points> ends;
  for (const Index threads : {1, 2}) {
    setNumThreads(threads);
    Simulation s = makeSimulation(scene);
    for (int k = 0; k < 20; ++k) ASSERT_TRUE(s.step().ok);
    const auto saved = s.snapshot();
    for (const bool again : {false, true}) {
      if (again) s.restore(saved);
      for (int k = 0; k < 20; ++k) ASSERT_TRUE(s.step().ok);
      ends.push_back(s.state().positions);
    }
  }
  setNumThreads(1);
  for (const Points& end : ends) EXPECT_EQ(end, ends.front());
}

TEST(SoftPad, ThatIsHarderThanContactWithoutItIsTold) {
  for (const double compliance : {1e-12, 3e-3 / kSheetPressure}) {
    SceneParams scene = makeSheetScene(Type::kVerlet, 144, 0.2);
    scene.contact.compliance = compliance;
    Simulation s = makeSimulation(scene);
    std::string notices;
    for (int k = 0; k < 3; ++k) notices += s.step().notice;
    const std::string begin = "contact.compliance is 1e-12 m/Pa, but contact without pads already yields with tools by up to ";
    const auto at = notices.find(begin);
    EXPECT_EQ(at != std::string::npos, compliance == 1e-12) << notices;
    EXPECT_EQ(notices.find(begin, at == std::string::npos ? at : at + 1), std::string::npos);
  }
}

// Areas of the points of a sheet whose halves differ in density, and of a box.
TEST(ContactAreas, SumToThatOfTheSurface) {
  SceneParams scene = makeSheetScene(Type::kVerlet, 200, 0.2);
  simulation::RegionParams heavy;
  heavy.region.min = Vec3(0.0, -9.0, -9.0);
  heavy.region.max = Vec3(9.0, 9.0, 9.0);
  heavy.material.density = 5000.0;
  scene.regions.push_back(heavy);
  const simulation::RestSurface sheet = simulation::buildRestSurface(scene, io::makeShape(scene.cloud));
  const std::vector<double> areas = simulation::findContactAreas(scene, sheet, *sheet.model).of_points;
  EXPECT_NEAR(std::accumulate(areas.begin(), areas.end(), 0.0), sheet.area, 1e-9);
  double right = 0.0;
  for (std::size_t i = 0; i < areas.size(); ++i) right += sheet.points[i].x() > 0.0 ? areas[i] : 0.0;
  EXPECT_NEAR(right, 0.5 * sheet.area, 0.06 * sheet.area);

  const SceneParams of_block = makeBlockScene(Type::kVerlet, 400, 0.2);
  const simulation::RestSurface block = simulation::buildRestSurface(of_block, io::makeShape(of_block.cloud));
  const std::vector<double> skin = simulation::findContactAreas(of_block, block, *block.model).of_points;
  double bottom = 0.0, inside = 0.0;
  for (std::size_t i = 0; i < skin.size(); ++i) {
    const Vec3& p = block.points[i];
    if (p.z() < -0.05 + 1e-9) bottom += skin[i];
    if (std::abs(p.z()) < 0.03 && std::abs(p.y()) < 0.03 && p.x() > 0.02 && p.x() < 0.18) inside += skin[i];
  }
  EXPECT_NEAR(bottom, 0.2 * 0.1, 0.03 * 0.02);
  EXPECT_EQ(inside, 0.0);
}

TEST(SoftPad, RefusesPlanarSolidsAndBadValues) {
  SceneParams planar = makeScene(Type::kVerlet, 0.2);
  planar.model = "elastic_solid";
  planar.cloud.shape = simulation::CloudParams::Shape::kSheet;
  planar.cloud.points = 200;
  planar.contact.compliance = 1e-6;
  try {
    makeSimulation(planar);
    ADD_FAILURE() << "not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("contact.compliance: found"), std::string::npos) << error.what();
  }
  SceneParams scene = makeSheetScene(Type::kVerlet, 144, 0.2);
  for (const double bad : {-1e-6, 2.0, std::nan("")}) {
    scene.contact.compliance = bad;
    EXPECT_FALSE(checkParams(scene).empty()) << bad;
  }
}

}  // namespace
}  // namespace deformable_surface::test
