// Elastic solids as scenes: building from a cloud, motion, fewer points, and refused scenes.
#include "../model/solids.h"
#include "clouds.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <gtest/gtest.h>

#include <random>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

// A bar of soft rubber, clamped at x = 0.
SceneParams makeBarScene(Index points = 600) {
  SceneParams scene;
  scene.model = "elastic_solid";
  scene.cloud.shape = simulation::CloudParams::Shape::kBar;
  scene.cloud.points = points;
  scene.cloud.size = Vec2(0.4, 0.1);
  scene.cloud.height = 0.1;
  scene.cloud.jitter = 0.2;
  scene.material.poisson_ratio = 0.3;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(1e-6, 1.0, 1.0);
  scene.pins.push_back(pin);
  return scene;
}

tool::ToolParams makeFloor(double height) {
  tool::ToolParams floor;
  floor.id = "floor";
  floor.shape.kind = geometry::Solid::Kind::kPlane;
  floor.path.resize(1);
  floor.path[0].position = Vec3(0.0, 0.0, height);
  return floor;
}

Simulation makeSimulation(const SceneParams& scene) { return Simulation(scene, io::makeShape(scene.cloud)); }

bool hasNote(const Simulation& s, const std::string& part) {
  for (const std::string& note : s.buildNotes())
    if (note.find(part) != std::string::npos) return true;
  return false;
}

TEST(SolidSimulation, WeighsWhatItsBodyDoes) {
  const Simulation s = makeSimulation(makeBarScene());
  double mass = 0.0;
  for (double m : s.model().masses()) mass += m;
  EXPECT_NEAR(mass, 1000.0 * 0.004, 1e-3 * 4.0);  // cells of jittered points overlap a little where neighbours end
}

// Undamped: the potential energy becomes stored and kinetic energy.
TEST(SolidSimulation, SwingsUnderItsWeightAndKeepsItsEnergy) {
  for (const model::SolidLaw law : {model::SolidLaw::kCorotated, model::SolidLaw::kNeoHookean}) {
    SceneParams scene = makeBarScene();
    scene.material.young_modulus = 1e6;
    scene.elastic_solid.law = law;
    Simulation s = makeSimulation(scene);
    double lowest = 0.0, largest_energy = 0.0;
    const double before = s.statistics().potential_energy;
    for (int k = 0; k < 60; ++k) {
      ASSERT_TRUE(s.step().ok);
      const simulation::Statistics now = s.statistics();
      lowest = std::min(lowest, s.surface(false).positions.back().z() - 0.05);
      largest_energy = std::max(largest_energy, now.kinetic_energy);
      EXPECT_NEAR(now.kinetic_energy + now.elastic_energy + now.potential_energy, before, 0.02 * largest_energy + 1e-9);
    }
    // Euler and Bernoulli's deflection is rho g L^4 12 / (8 E h^2) = 0.038 m at rest, and twice that in a sudden fall. Shear adds
    // a little.
    EXPECT_LT(lowest, -0.065);
    EXPECT_GT(lowest, -0.095);
  }
}

TEST(SolidSimulation, GivesTheSameBitsForEveryNumberOfThreads) {
  SceneParams scene = makeBarScene(1500);
  std::uint64_t hash = 0;
  for (const Index threads : {1, 2, 3}) {
    setNumThreads(threads);
    Simulation s = makeSimulation(scene);
    run(s, 3);
    if (threads == 1) hash = s.stateHash();
    EXPECT_EQ(s.stateHash(), hash);
  }
  setNumThreads(0);
}

// Neighbourhoods along the body change nothing where there is no gap.
TEST(SolidSimulation, MovesAsWithEuclideanNeighboursWhereThereIsNoGap) {
  SceneParams scene = makeBarScene();
  Simulation over_body = makeSimulation(scene);
  scene.neighbors.geodesic_exponent = OrAuto<double>(1.0);
  Simulation in_space = makeSimulation(scene);
  run(over_body, 3);
  run(in_space, 3);
  EXPECT_EQ(over_body.stateHash(), in_space.stateHash());
}

TEST(SolidSimulation, IsSimplifiedToAsManyPointsAsAskedForAndCarriesTheOthersAlong) {
  SceneParams scene = makeBarScene(3000);
  scene.simplification.target_points = 400;
  Simulation s = makeSimulation(scene);
  EXPECT_EQ(s.state().size(), 400);
  EXPECT_EQ(s.surface(false).positions.size(), s.input().positions.size());
  double mass = 0.0;
  for (double m : s.model().masses()) mass += m;
  EXPECT_NEAR(mass, 4.0, 0.02 * 4.0);
  run(s, 10);
  // No point of the cloud moves far from its neighbours.
  const Points& now = s.surface(false).positions;
  for (std::size_t i = 0; i < now.size(); ++i) EXPECT_LT((now[i] - s.input().positions[i]).norm(), 0.1) << i;
}

// A tube along x that is clamped at one end and sags. Its wall is thinner than the distance of 300 points, whose hull is far too
// large.
TEST(SolidSimulation, OfFewPointsIsAsHeavyAndAsStiffAsItsCloud) {
  constexpr double kLength = 0.3, kMiddle = 0.03, kSpacing = 0.0075;
  Points tube;
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> jitter(-0.2 * kSpacing, 0.2 * kSpacing);
  for (Index i = 0; i <= 40; ++i)
    for (Index j = 0; j < 25; ++j)
      for (const double r : {-0.5 * kSpacing, 0.5 * kSpacing}) {
        const double angle = 2.0 * M_PI * j / 25 + jitter(generator) / kMiddle;
        const double x = i * kSpacing + (i > 0 && i < 40 ? jitter(generator) : 0.0);
        tube.emplace_back(x, (kMiddle + r) * std::cos(angle), (kMiddle + r) * std::sin(angle));
      }
  SceneParams scene = makeBarScene();
  scene.pins[0].region.max.x() = 0.02;
  scene.material.young_modulus = 1e6;
  scene.material.density = 1000.0;
  scene.gravity = Vec3(0.0, 0.0, -0.05);
  scene.integrator.type = solve::IntegratorType::kStatic;
  scene.accuracy.estimate = false;
  const double outer = kMiddle + 0.5 * kSpacing, inner = kMiddle - 0.5 * kSpacing, area = M_PI * (outer * outer - inner * inner);
  double sag = 0.0;
  for (const Index points : {0, 800, 300}) {
    scene.simplification = {};
    if (points == 0) scene.simplification.method = cloud::SimplificationMethod::kNone;
    scene.simplification.target_points = points;
    Simulation s(scene, asCloud(tube));
    double mass = 0.0;
    for (const double m : s.model().masses()) mass += m;
    EXPECT_NEAR(mass, 1000.0 * area * kLength, 0.02 * 1000.0 * area * kLength) << points;
    run(s, 1);
    const Points& positions = s.surface(false).positions;
    double now = 0.0;
    for (std::size_t i = 0; i < tube.size(); ++i) now = std::max(now, (positions[i] - tube[i]).norm());
    if (points == 0) sag = now;
    EXPECT_NEAR(now, sag, 0.1 * sag) << points;
  }
}

// Like voxels of slices that are 1.6 times as thick as the voxels are wide: a bar along x, which sags.
TEST(SolidSimulation, OfLayersThatAreFartherApartIsOneBody) {
  SceneParams scene = makeBarScene();
  scene.material.young_modulus = 1e6;
  scene.gravity = Vec3(0.0, 0.0, -0.5);
  scene.integrator.type = solve::IntegratorType::kStatic;
  scene.accuracy.estimate = false;
  double sag = 0.0;
  for (const double jitter : {0.0, 0.15})
    for (const Index points : {0, 800}) {
      Points bar = makeBox(26, 9, 9, 1.0, jitter);
      for (Vec3& p : bar) p = Vec3(0.012 * p.x(), 0.0075 * p.y(), 0.0075 * p.z());
      scene.simplification = {};
      if (points == 0) scene.simplification.method = cloud::SimplificationMethod::kNone;
      scene.simplification.target_points = points;
      Simulation s(scene, asCloud(bar));
      EXPECT_TRUE(hasNote(s, "the body is sampled more densely in one direction than in another: gaps narrower than about 0.01"));
      double mass = 0.0;
      for (const double m : s.model().masses()) mass += m;
      EXPECT_NEAR(mass, 1000.0 * 0.3 * 0.06 * 0.06, 0.01) << points;
      run(s, 1);
      const Points& positions = s.surface(false).positions;
      double now = 0.0;
      for (std::size_t i = 0; i < bar.size(); ++i) now = std::max(now, (positions[i] - bar[i]).norm());
      if (sag == 0.0) sag = now;
      EXPECT_NEAR(now, sag, 0.1 * sag) << points << " points, jitter " << jitter;
    }
}

TEST(SolidSimulation, RefusesANeoHookeanPlate) {
  SceneParams scene = makeBarScene();
  scene.elastic_solid.law = model::SolidLaw::kNeoHookean;
  EXPECT_EQ(problemOf(scene, sheetCloud()),
            "elastic_solid.law: found neo_hookean for a plate; accepted: corotated or linear, or elastic_solid.plane: strain");
  scene.elastic_solid.plane = model::PlaneKind::kStrain;
  EXPECT_EQ(problemOf(scene, sheetCloud()), "accepted");
}

TEST(SolidSimulation, RefusesWhatIsNoBody) {
  SceneParams scene = makeBarScene();
  scene.pins.clear();
  EXPECT_NE(
      problemOf(scene, asCloud(makeSphere(800, 0.5).points)).find("and with elastic_solid.fill: true those of a closed surface"),
      std::string::npos);
  Points line;
  for (int k = 0; k < 20; ++k) line.push_back(Vec3(0.1 * k, 0.0, 0.0));
  EXPECT_NE(problemOf(scene, asCloud(line)).find("lie on a line"), std::string::npos);
  scene.elastic_solid.dimension = model::SolidDimension::kPlanar;
  EXPECT_NE(problemOf(scene, io::makeShape(scene.cloud)).find("elastic_solid.dimension: found planar"), std::string::npos);
  scene.elastic_solid.dimension = model::SolidDimension::kVolume;
  EXPECT_NE(problemOf(scene, sheetCloud()).find("elastic_solid.dimension: found volume"), std::string::npos);
}

// A plate in the x-z plane: gravity along z moves it, along y it cannot.
TEST(SolidSimulation, APlanarCloudMovesInItsPlaneOnly) {
  SceneParams scene = makeBarScene();
  scene.cloud.shape = simulation::CloudParams::Shape::kTwoBars;
  scene.cloud.points = 500;
  scene.cloud.size = Vec2(0.4, 0.08);
  scene.cloud.gap = 0.03;
  scene.gravity = Vec3(0.0, 5.0, -9.81);
  Simulation s = makeSimulation(scene);
  ASSERT_EQ(s.buildWarnings().size(), 1u);
  EXPECT_NE(s.buildWarnings()[0].find("gravity perpendicular to it is ignored"), std::string::npos);
  EXPECT_TRUE(hasNote(s, "a planar solid"));
  run(s, 10);
  double lowest = 0.0;
  for (const Vec3& p : s.state().positions) {
    EXPECT_EQ(p.y(), 0.0);
    lowest = std::min(lowest, p.z());
  }
  EXPECT_LT(lowest, -0.1);
}

TEST(SolidSimulation, TellsAVonMisesStressThatIsLargestAtTheClamp) {
  SceneParams scene = makeBarScene();
  scene.material.damping = 8.0;
  Simulation s = makeSimulation(scene);
  run(s, 100);
  std::vector<double> stress;
  s.model().stresses()->computePointStress(s.state(), stress);
  const Index largest = static_cast<Index>(std::max_element(stress.begin(), stress.end()) - stress.begin());
  EXPECT_LT(s.state().positions[largest].x(), 0.05);
  // M h / 2 I = 3 rho g L^2 / h = 47 kPa at the clamp's outer fibres by the theory of thin bars.
  EXPECT_GT(stress[largest], 25e3);
  EXPECT_LT(stress[largest], 75e3);
}

// The largest distance between the same points of two simulations.
double findDistance(const Simulation& a, const Simulation& b) {
  double largest = 0.0;
  for (Index i = 0; i < a.state().size(); ++i)
    largest = std::max(largest, (a.state().positions[i] - b.state().positions[i]).norm());
  return largest;
}

// After two seconds exp(-16 / 2) of the motion remains. The error of the solution itself is smaller.
TEST(SolidSimulation, FindsTheEquilibriumThatItSettlesTo) {
  SceneParams scene = makeBarScene();
  scene.material.damping = 8.0;
  Simulation settled = makeSimulation(scene);
  run(settled, 300);
  scene.integrator.type = solve::IntegratorType::kStatic;
  Simulation solved = makeSimulation(scene);
  const simulation::StepOutcome outcome = solved.step();
  ASSERT_TRUE(outcome.ok) << outcome.problem;
  EXPECT_EQ(outcome.notice, "");
  EXPECT_LT(solved.surface(false).positions.back().z(), -0.1);  // bent by a right angle and more: far from linear
  EXPECT_LT(findDistance(solved, settled), 1e-4);
}

// Whether nothing is told but that Verlet takes less time.
bool isOnlyOnWork(const std::string& notice) {
  return notice.empty() ||
         (notice.find("steps of integrator.type implicit now take ") == 0 && notice.find("; ") == std::string::npos);
}

// The fall of a clamped bar with steps forty times as long as Verlet's: no energy is created, and it ends where the bar ends, up
// to exp(-8) of the distance.
TEST(SolidSimulation, TakesLongImplicitStepsWithoutMakingEnergy) {
  SceneParams scene = makeBarScene();
  scene.material.damping = 8.0;
  scene.integrator.type = solve::IntegratorType::kImplicit;
  scene.integrator.time_step = 1.0 / 30.0;
  Simulation s = makeSimulation(scene);
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 60; ++k) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
    EXPECT_TRUE(isOnlyOnWork(outcome.notice)) << outcome.notice;
    const simulation::Statistics now = s.statistics();
    const double energy = now.kinetic_energy + now.elastic_energy + now.potential_energy;
    EXPECT_LT(energy, last + 1e-9 * std::abs(last)) << k;
    last = energy;
  }
  scene.integrator.type = solve::IntegratorType::kStatic;
  Simulation solved = makeSimulation(scene);
  ASSERT_TRUE(solved.step().ok);
  EXPECT_LT(findDistance(s, solved), 1e-3);
}

// Second order: halved steps have a quarter of the error, against Verlet with a far smaller error.
TEST(SolidSimulation, ImplicitStepsAreOfSecondOrder) {
  SceneParams scene = makeBarScene(300);
  scene.gravity = Vec3(0.0, 0.0, -0.5);
  const auto runFor = [&](solve::IntegratorType type, double step) {
    scene.integrator.type = type;
    scene.integrator.time_step = step;
    Simulation s = makeSimulation(scene);
    run(s, static_cast<int>(std::lround(0.16 / step)));
    return s;
  };
  const Simulation exact = runFor(solve::IntegratorType::kVerlet, 1e-4);
  const double coarse = findDistance(runFor(solve::IntegratorType::kImplicit, 0.01), exact);
  const double fine = findDistance(runFor(solve::IntegratorType::kImplicit, 0.005), exact);
  EXPECT_GT(std::log2(coarse / fine), 1.5);
}

// The momentum of a fall is far larger than the motion within the body. The tolerance is relative to it, too.
TEST(SolidSimulation, ALooseToleranceLeavesNoMotionOutOfImplicitSteps) {
  SceneParams scene = makeBarScene(300);
  scene.gravity = Vec3(0.0, 0.0, -0.5);
  scene.integrator.type = solve::IntegratorType::kImplicit;
  const auto runFor = [&](double tolerance, double step) {
    scene.integrator.tolerance = tolerance;
    scene.integrator.time_step = step;
    Simulation s = makeSimulation(scene);
    for (int k = 0; k < std::lround(0.2 / step); ++k) {
      const simulation::StepOutcome outcome = s.step();
      EXPECT_TRUE(outcome.ok) << outcome.problem;
      EXPECT_TRUE(isOnlyOnWork(outcome.notice)) << outcome.notice;
    }
    return s;
  };
  const Simulation tight = runFor(1e-6, 1.0 / 120.0);
  const double of_step = findDistance(tight, runFor(1e-6, 1.0 / 240.0));
  for (const double tolerance : {1e-2, 0.1}) EXPECT_LT(findDistance(tight, runFor(tolerance, 1.0 / 120.0)), 3.0 * of_step);
}

TEST(SolidSimulation, AutoGoesOverToImplicitWhereVerletNeedsTooManySubsteps) {
  SceneParams scene = makeBarScene();
  scene.integrator.max_substeps = 2;
  scene.material.young_modulus *= 1e4;  // so that an implicit step is not far more work
  Simulation s = makeSimulation(scene);
  const simulation::StepOutcome outcome = s.step();
  EXPECT_TRUE(outcome.ok) << outcome.problem;
  EXPECT_NE(outcome.notice.find("implicit is used"), std::string::npos) << outcome.notice;
  EXPECT_EQ(s.lastIntegrator(), solve::IntegratorType::kImplicit);
}

TEST(SolidSimulation, ImplicitStepsGiveTheSameBitsForEveryNumberOfThreads) {
  SceneParams scene = makeBarScene(1500);
  scene.integrator.type = solve::IntegratorType::kImplicit;
  std::uint64_t hash = 0;
  for (const Index threads : {1, 2, 3}) {
    setNumThreads(threads);
    Simulation s = makeSimulation(scene);
    run(s, 2);
    if (threads == 1) hash = s.stateHash();
    EXPECT_EQ(s.stateHash(), hash);
  }
  setNumThreads(0);
}

TEST(SolidSimulation, IsPushedByToolsAndHeldByGrips) {
  SceneParams scene = makeBarScene();
  scene.gravity.setZero();
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.05;
  tool::WaypointParams from, to;
  from.position = Vec3(0.4, 0.0, 0.2);
  to.time = 0.3;
  to.position = Vec3(0.4, 0.0, 0.05);
  ball.path = {from, to};
  scene.tools.push_back(ball);
  Simulation s = makeSimulation(scene);
  run(s, 30);
  double lowest = 0.0;
  for (const Vec3& p : s.state().positions) lowest = std::min(lowest, p.z());
  EXPECT_LT(lowest, -0.06);
}

// Points of a body at rest leave the floor and return within few sub-steps.
// An implicit step in which a body hits the floor must not throw it back with more energy than it had.
TEST(SolidSimulation, ALongStepTakesAnImpactWithoutMakingEnergy) {
  for (const double young : {1e7, 1e8}) {
    SceneParams scene = makeBarScene();
    scene.cloud.points = 400;
    scene.cloud.size = {0.02, 0.014};
    scene.cloud.height = 0.01;
    scene.cloud.jitter = 0.1;
    scene.material.young_modulus = young;
    scene.integrator.type = solve::IntegratorType::kImplicit;
    scene.integrator.time_step = 0.01;
    scene.accuracy.estimate = false;
    scene.pins.clear();
    scene.tools = {makeFloor(-0.025)};
    Simulation s = makeSimulation(scene);
    const double potential = s.statistics().potential_energy;
    double energy = 0.0, largest = 0.0;
    for (int k = 0; k < 25; ++k) {
      const simulation::StepOutcome outcome = s.step();
      ASSERT_TRUE(outcome.ok) << young << ": " << outcome.problem;
      const simulation::Statistics now = s.statistics();
      largest = std::max(largest, now.kinetic_energy);
      energy = now.kinetic_energy + now.elastic_energy + now.potential_energy - potential;
      EXPECT_LT(energy, 0.01 * largest) << young << ", step " << k;
    }
    EXPECT_LT(energy, -0.1 * largest) << young;  // it has lost some in the impact
  }
}

// The penalty of contact takes little of the force on a palpating ball.
TEST(SolidSimulation, ABallFeelsInMotionWhatItFeelsInEquilibrium) {
  const auto findForce = [](bool in_motion) {
    SceneParams scene = makeBarScene();
    scene.gravity.setZero();
    scene.material.young_modulus = 2e4;
    scene.material.damping = in_motion ? 60.0 : 0.0;
    if (!in_motion) scene.integrator.type = solve::IntegratorType::kStatic;
    scene.accuracy.estimate = false;
    scene.pins.front().region.max = Vec3(1.0, 1.0, 1e-9 - 0.03);
    tool::ToolParams ball;
    ball.id = "ball";
    ball.shape.radius = 0.015;
    ball.path.resize(2);
    ball.path[0].position = Vec3(0.0, 0.0, 0.015);
    ball.path[1].position = Vec3(0.0, 0.0, 0.012);
    ball.path[1].time = 0.1;
    scene.tools = {ball};
    cloud::PointCloud block;
    std::mt19937 generator(3);
    for (int x = -6; x <= 6; ++x)
      for (int y = -6; y <= 6; ++y)
        for (int z = -6; z <= 0; ++z)
          block.positions.push_back(0.005 * (Vec3(x, y, z) + 0.1 * randomVector(generator).cwiseProduct(Vec3(1, 1, z % 6 != 0))));
    block.width = static_cast<std::uint32_t>(block.positions.size());
    Simulation s(scene, block);
    run(s, in_motion ? 35 : 15);
    return s.toolReactions().front().force.z();
  };
  const double in_equilibrium = findForce(false), in_motion = findForce(true);
  EXPECT_GT(in_equilibrium, 0.1);
  EXPECT_GT(in_motion, 0.94 * in_equilibrium);
  EXPECT_LT(in_motion, 1.01 * in_equilibrium);
}

// Hertz's half-space, up to a depth of a fifth of the block. Without places on the skin the ball of four spacings goes through,
// and one of two spacings meets hardly any force.
TEST(SolidSimulation, ABallPressedDeepBetweenThePointsFeelsTheBody) {
  const double spacing = 0.2 / 12.0;
  cloud::PointCloud block;
  block.positions = makeBox(13, 13, 7, spacing, 0.2);
  for (const double radius : {spacing, 2.0 * spacing}) {
    SceneParams scene = makeBarScene();
    scene.gravity.setZero();
    scene.material.young_modulus = 2e4;
    scene.material.poisson_ratio = 0.3;
    scene.material.damping = 5.0;
    scene.accuracy.estimate = false;
    scene.pins.front().region.min = Vec3(-1.0, -1.0, -1.0);
    scene.pins.front().region.max = Vec3(1.0, 1.0, 0.001);
    tool::ToolParams ball;
    ball.id = "ball";
    ball.shape.radius = radius;
    const Vec3 top(0.103, 0.104, 0.1 + radius);
    ball.path = {{0.0, top, Vec4(0.0, 0.0, 0.0, 1.0)}, {0.6, top - Vec3(0.0, 0.0, 0.06), Vec4(0.0, 0.0, 0.0, 1.0)}};
    scene.tools = {ball};
    Simulation s(scene, block);
    std::vector<double> force;  // N, at depths of 20, 40 and 60 mm
    for (int third = 0; third < 3; ++third) {
      run(s, 20);
      force.push_back(s.toolReactions().front().force.z());
    }
    const double hertz = 4.0 / 3.0 * 2e4 / (1.0 - 0.3 * 0.3) * std::sqrt(radius) * std::pow(0.02, 1.5);
    EXPECT_GT(force[0], 0.7 * hertz) << radius;
    EXPECT_LT(force[0], 1.3 * hertz) << radius;
    if (radius > 1.5 * spacing) {
      EXPECT_GT(force[1], 1.5 * force[0]);
      EXPECT_GT(force[2], force[1]);
    }
  }
}

// A tool that came back to places on the skin by as much as it moved gave the body up to 1.8 times the work of its force.
TEST(SolidSimulation, AMovingToolGivesNoMoreEnergyThanTheWorkOfItsForce) {
  SceneParams scene = makeBarScene();
  scene.gravity.setZero();
  scene.material.young_modulus = 2e4;
  scene.material.damping = 2.0;
  scene.accuracy.estimate = false;
  scene.integrator.time_step = 5e-4;
  scene.pins.front().region.min = Vec3(-1.0, -1.0, -1.0);
  scene.pins.front().region.max = Vec3(1.0, 1.0, 0.001);
  tool::ToolParams box;
  box.id = "box";
  box.shape.kind = geometry::Solid::Kind::kBox;
  box.shape.size = Vec3(0.028, 0.028, 0.028);
  const Vec3 top(0.103, 0.104, 0.114);
  const double speed = 0.06;
  box.path = {{0.0, top, Vec4(0.0, 0.0, 0.0, 1.0)}, {0.3, top - Vec3(0.0, 0.0, 0.3 * speed), Vec4(0.0, 0.0, 0.0, 1.0)}};
  scene.tools = {box};
  cloud::PointCloud block;
  block.positions = makeBox(11, 11, 6, 0.02, 0.4);
  Simulation s(scene, block);
  double work = 0.0;  // J
  for (int k = 0; k < 600; ++k) {
    ASSERT_TRUE(s.step().ok);
    work += s.toolReactions().front().force.z() * speed * scene.integrator.time_step;
  }
  const simulation::Statistics end = s.statistics();
  EXPECT_GT(work, 0.01);
  EXPECT_LT(end.kinetic_energy + end.elastic_energy, 1.01 * work);
}

TEST(SolidSimulation, ABallOnAFloorWithoutFrictionGainsNoEnergy) {
  SceneParams scene = makeBarScene();
  scene.cloud = {};
  scene.cloud.shape = simulation::CloudParams::Shape::kSphere;
  scene.cloud.points = 500;
  scene.cloud.radius = 0.1;
  scene.elastic_solid.fill = true;
  scene.material.young_modulus = 1e5;
  scene.material.poisson_ratio = 0.4;
  scene.material.density = 1000.0;
  scene.material.damping = 6.0;
  scene.pins.clear();
  scene.accuracy.estimate = false;
  scene.tools = {makeFloor(-0.11)};
  Simulation s = makeSimulation(scene);
  double least = std::numeric_limits<double>::infinity(), rise = 0.0, most_elastic = 0.0;
  for (int k = 0; k < 250; ++k) {
    ASSERT_TRUE(s.step().ok);
    const simulation::Statistics now = s.statistics();
    const double energy = now.kinetic_energy + now.elastic_energy + now.potential_energy;
    least = std::min(least, energy);
    rise = std::max(rise, energy - least);
    most_elastic = std::max(most_elastic, now.elastic_energy);
  }
  EXPECT_LT(rise, 1e-3 * most_elastic);
  EXPECT_LT(s.statistics().max_speed, 0.1);
}

}  // namespace
}  // namespace deformable_surface::test
