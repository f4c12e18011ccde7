// Knives and tears in a mass-spring surface: what separates, what stays, and that each point follows its own side.
#include "../../src/simulation/state_hash.h"
#include "clouds.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/expectations.h"
#include "deformable_surface/tool/blade.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

namespace deformable_surface::test {
namespace {

/// Moves along y through the line x = 0.513 of the sheet, within a tenth of a second.
tool::ToolParams knife(double thickness = 0.002) {
  tool::ToolParams tool;
  tool.id = "knife";
  tool.mode = tool::Mode::kCut;
  tool.shape.kind = geometry::Solid::Kind::kBox;
  tool.shape.size = Vec3(thickness, 0.1, 0.4);
  tool.path = {{0.0, Vec3(0.513, -0.7, 0.0)}, {0.1, Vec3(0.513, 0.7, 0.0)}};
  return tool;
}

/// A sheet at rest and without weight, held along x = 0.
simulation::SceneParams stillSheet() {
  simulation::SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.tools = {knife()};
  return p;
}

bool isLeft(const Vec3& point) { return point.x() < 0.513; }

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

TEST(Cutting, AKnifePartsTheSheetAlongItsWayAndNowhereElse) {
  for (double thickness : {1e-5, 0.002, 0.02}) {
    simulation::SceneParams p = stillSheet();
    p.tools[0] = knife(thickness);
    simulation::Simulation s(p, sheetCloud());
    const std::size_t links = stretchLinksOf(s.model()).size();
    run(s, 12);
    EXPECT_EQ(simulation::computeQuantity("components", s), 2.0) << thickness;
    EXPECT_EQ(simulation::computeQuantity("isolated", s), 0.0) << thickness;
    std::size_t near = 0;
    for (const auto& [a, b] : stretchLinksOf(s.model()))
      EXPECT_EQ(isLeft(s.state().positions[a]), isLeft(s.state().positions[b]));
    const simulation::Simulation whole(stillSheet(), sheetCloud());
    for (const auto& [a, b] : stretchLinksOf(whole.model()))
      near += isLeft(whole.state().positions[a]) != isLeft(whole.state().positions[b]);
    // Apart from crossed links, only links are removed whose triangles on both sides were crossed.
    EXPECT_GE(links - near, stretchLinksOf(s.model()).size());
    EXPECT_GT(stretchLinksOf(s.model()).size(), links - near - 6) << thickness;
  }
}

TEST(Cutting, AKnifeThatJumpsAKilometreThroughItCutsAsOneThatGoesSlowly) {
  simulation::SceneParams p = stillSheet();
  p.tools[0].path = {{0.0, Vec3(0.513, -500.0, 0.0)}, {p.integrator.time_step, Vec3(0.513, 500.0, 0.0)}};
  simulation::Simulation s(p, sheetCloud()), slow(stillSheet(), sheetCloud());
  run(s, 1);
  run(slow, 12);
  EXPECT_EQ(simulation::computeQuantity("components", s), 2.0);
  EXPECT_EQ(stretchLinksOf(s.model()), stretchLinksOf(slow.model()));
}

// Its flat side lies in the sheet: it is near each link over its whole length.
TEST(Cutting, AKnifeThatSlidesAlongItsFlatCutsTheSameInOneStepAsInMany) {
  simulation::SceneParams p = stillSheet();
  p.tools[0].shape.size = Vec3(0.3, 0.3, 0.001);
  const Vec3 from(-1.0, 0.013, 0.0), to(2.0, 0.013, 0.0);
  p.tools[0].path = {{0.0, from}, {p.integrator.time_step, to}};
  simulation::Simulation fast(p, sheetCloud());
  run(fast, 1);
  p.tools[0].path[1].time = 10.0 * p.integrator.time_step;
  simulation::Simulation slow(p, sheetCloud());
  run(slow, 10);
  EXPECT_EQ(stretchLinksOf(fast.model()), stretchLinksOf(slow.model()));
}

TEST(Cutting, ABladeThatMovesAcrossItsFlatSideIsToldOnce) {
  for (const bool is_flat : {false, true}) {
    simulation::SceneParams p = stillSheet();
    tool::ToolParams blade;
    blade.id = "blade";
    blade.mode = tool::Mode::kCut;
    blade.shape.kind = geometry::Solid::Kind::kBox;
    blade.shape.size = is_flat ? Vec3(0.002, 2.0, 0.2) : Vec3(0.2, 0.002, 0.2);
    blade.path = {{0.0, Vec3(-0.3, 0.513, 0.0)}, {0.1, Vec3(1.3, 0.513, 0.0)}};
    p.tools = {blade};
    simulation::Simulation s(p, sheetCloud());
    std::string notices;
    for (int k = 0; k < 12; ++k) notices += s.step().notice;
    const std::size_t at = notices.find("single points in one step: its flat side and the surface move across each other");
    EXPECT_EQ(at != std::string::npos, is_flat) << notices;
    EXPECT_EQ(notices.find("single points"), notices.rfind("single points")) << notices;
  }
}

TEST(Cutting, TakesNoMassAndLeavesASheetAtRestAtRest) {
  simulation::Simulation s(stillSheet(), sheetCloud());
  const Points rest = s.state().positions;
  const double mass = sum(s.model().masses());
  run(s, 30);
  EXPECT_EQ(sum(s.model().masses()), mass);
  EXPECT_NE(s.stateHash(), simulation::hashState(s.state()));  // of the cut
  for (std::size_t i = 0; i < rest.size(); ++i) EXPECT_LT((s.state().positions[i] - rest[i]).norm(), 1e-12);
  EXPECT_LT(s.statistics().elastic_energy, 1e-20);
}

TEST(Cutting, EachPointOfTheCloudGoesWithItsOwnSide) {
  // After the cut the free half is carried away as a whole: every point of the cloud either stays or moves the full distance.
  simulation::SceneParams p = stillSheet();
  tool::ToolParams hand;
  hand.id = "hand";
  hand.mode = tool::Mode::kMove;
  hand.shape.kind = geometry::Solid::Kind::kBox;
  hand.shape.size = Vec3(1.0 - 0.513, 2.0, 0.1);
  const Vec3 middle(0.5 * (1.0 + 0.513) + 1e-9, 0.0, 0.0);
  hand.start = 0.15;
  hand.path = {{0.2, middle}, {0.7, middle + Vec3(0.3, 0.1, 0.2)}};
  p.tools.push_back(hand);
  p.tools[1].path[1].orientation = Vec4(0.0, 0.0, std::sin(0.3), std::cos(0.3));
  const cloud::PointCloud cloud = sheetCloud(60);
  simulation::Simulation s(p, cloud);
  run(s, 80);
  const simulation::Surface& surface = s.surface(true);
  const Eigen::AngleAxisd turn(0.6, Vec3::UnitZ());
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3& x = cloud.positions[i];
    if (std::abs(x.x() - 0.513) < 0.002) continue;  // in the knife
    const Vec3 place = isLeft(x) ? x : Vec3(middle + Vec3(0.3, 0.1, 0.2) + turn * (x - middle));
    EXPECT_LT((surface.positions[i] - place).norm(), 1e-6) << x.transpose();
  }
}

TEST(Cutting, AForkOfACutSheetBesideAToolGoesOnBitForBit) {
  simulation::SceneParams p = stillSheet();
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = 0.1;
  ball.path = {{0.0, Vec3(0.8, 0.0, -0.09)}};
  p.tools.push_back(ball);
  simulation::Simulation s(p, sheetCloud());
  run(s, 12);
  ASSERT_EQ(simulation::computeQuantity("components", s), 2.0);
  simulation::Simulation fork = s.fork(), viewer = s.viewer();
  EXPECT_EQ(viewer.surface(true).positions, s.surface(true).positions);
  run(s, 5);
  run(fork, 5);
  EXPECT_EQ(fork.stateHash(), s.stateHash());
}

// How finely a knife's way is followed depends on the links of the whole surface. The first knife takes the longest ones.
TEST(Cutting, AForkOfACutSheetIsCutOnAsTheSheetIs) {
  std::mt19937 random(5);
  const auto draw = [&](double from, double to) { return from + (to - from) * static_cast<double>(random()) / 4294967296.0; };
  Points points;
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 14; ++j) points.emplace_back(0.05 * i, 0.07 * j + draw(-0.01, 0.01), 0.0);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 6; ++j) points.emplace_back(0.62 + 0.17 * i + draw(-0.03, 0.03), 0.18 * j + draw(-0.03, 0.03), 0.0);
  simulation::SceneParams p = stillSheet();
  p.accuracy.estimate = false;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.tools[0].shape.size = Vec3(1.5, 0.01, 1.5);
  p.tools[0].path = {{0.0, Vec3(1.35, -0.7, 0.0)}, {0.1, Vec3(1.35, 2.0, 0.0)}};
  for (int k = 0; k < 20; ++k) {
    tool::ToolParams blade = knife();
    blade.id = "blade " + std::to_string(k);
    blade.shape.size = Vec3(draw(0.001, 0.01), 0.05, draw(0.01, 0.4));
    blade.path.clear();
    for (const double time : {0.15, 0.18})
      blade.path.push_back({time, Vec3(draw(0.0, 0.5), time < 0.16 ? -0.7 : 0.7, draw(-0.2, 0.1)),
                            Vec4(draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0), 1.0).normalized()});
    p.tools.push_back(blade);
  }
  simulation::Simulation s(p, asCloud(points));
  const std::size_t whole = stretchLinksOf(s.model()).size();
  run(s, 13);
  const std::size_t begun = stretchLinksOf(s.model()).size();
  EXPECT_LT(begun, whole);
  simulation::Simulation fork = s.fork();
  run(s, 10);
  run(fork, 10);
  EXPECT_LT(stretchLinksOf(s.model()).size(), begun);
  EXPECT_EQ(stretchLinksOf(fork.model()), stretchLinksOf(s.model()));
  EXPECT_EQ(fork.stateHash(), s.stateHash());
}

TEST(Cutting, WhatHangsBelowTheCutFallsFreely) {
  simulation::SceneParams p = stillSheet();
  p.material.damping = 0.0;
  simulation::Simulation s(p, sheetCloud());
  run(s, 12);
  s.setGravity(Vec3(0.0, 0.0, -9.81));
  run(s, 20);
  for (Index i = 0; i < s.state().size(); ++i)
    if (!isLeft(s.state().positions[i])) {
      EXPECT_NEAR(s.state().velocities[i].z(), -9.81 * 0.2, 1e-9);
    }
}

TEST(Cutting, UnderTensionTheEnergyOnlyFallsAndTheGuardKeepsQuiet) {
  // Stretched, undamped and cut: the energy of the cut links is gone, and no step is refused or repeated.
  simulation::SceneParams p = stillSheet();
  p.material.damping = 0.0;
  simulation::PinParams far;
  far.region.min = Vec3(0.999, -1.0, -1.0);
  far.region.max = Vec3(1.001, 2.0, 1.0);
  p.pins.push_back(far);
  simulation::Simulation s(p, sheetCloud());
  model::State state = s.state();
  for (Vec3& x : state.positions) x.x() *= 1.05;
  s.setState(state);
  double last = s.statistics().elastic_energy;
  ASSERT_GT(last, 0.01);
  for (int k = 0; k < 60; ++k) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
    EXPECT_EQ(outcome.notice.find("energy"), std::string::npos) << outcome.notice;
    const double energy = s.statistics().elastic_energy + s.statistics().kinetic_energy;
    EXPECT_LT(energy, 1.001 * last);
    last = energy;
  }
  EXPECT_EQ(simulation::computeQuantity("components", s), 2.0);
}

TEST(Cutting, IsTheSameForEveryNumberOfThreadsAndAfterASnapshot) {
  simulation::SceneParams p = stillSheet();
  p.gravity = Vec3(0.0, 0.0, -9.81);
  const auto finish = [](simulation::Simulation& s, int steps) {
    run(s, steps);
    std::uint64_t hash = s.stateHash();
    for (const Vec3& x : s.surface(false).positions) hash = hash * 31u + std::hash<double>()(x.x() + 3.0 * x.z());
    return hash;
  };
  setNumThreads(1);
  simulation::Simulation one(p, sheetCloud());
  const std::uint64_t expected = finish(one, 20);
  setNumThreads(3);
  simulation::Simulation three(p, sheetCloud());
  EXPECT_EQ(finish(three, 20), expected);
  setNumThreads(1);

  // In the middle of the cut; then back to the state before it, and on again.
  simulation::Simulation s(p, sheetCloud());
  run(s, 6);
  const simulation::Snapshot snapshot = s.snapshot();
  run(s, 14);
  s.restore(snapshot);
  EXPECT_EQ(finish(s, 14), expected);
  s.reset();
  EXPECT_EQ(simulation::computeQuantity("components", s), 1.0);
  EXPECT_EQ(finish(s, 20), expected);
}

TEST(Cutting, TheErrorEstimateSaysThatItEnds) {
  simulation::SceneParams p = stillSheet();
  p.accuracy.estimate = true;
  p.gravity = Vec3(1.0, 0.0, 0.0);  // pulls at the pins
  simulation::Simulation s(p, sheetCloud());
  run(s, 1);
  ASSERT_TRUE(std::isfinite(s.statistics().error_estimate));
  int told = 0;
  for (int k = 0; k < 20; ++k) told += s.step().notice.find("no error estimate") != std::string::npos;
  EXPECT_EQ(told, 1);
  EXPECT_FALSE(std::isfinite(s.statistics().error_estimate));
}

TEST(Cutting, SpringsAreCutAsTrianglesAre) {
  simulation::SceneParams p = stillSheet();
  p.mass_spring.membrane = model::Membrane::kSprings;
  p.mass_spring.bending = model::Bending::kSprings;
  p.material.poisson_ratio = 1.0 / 3.0;
  simulation::Simulation s(p, sheetCloud());
  run(s, 12);
  EXPECT_EQ(simulation::computeQuantity("components", s), 2.0);
  for (const auto* links : {&stretchLinksOf(s.model()), &bendLinksOf(s.model())})
    for (const auto& [a, b] : *links) EXPECT_EQ(isLeft(s.state().positions[a]), isLeft(s.state().positions[b]));
}

TEST(Tearing, BeginsBeyondTheStrainAndNotBefore) {
  for (double strain : {0.08, 0.12}) {
    simulation::SceneParams p = stillSheet();
    p.tools.clear();
    p.mass_spring.tear_strain = 0.1;
    simulation::Simulation s(p, sheetCloud());
    const std::size_t links = stretchLinksOf(s.model()).size();
    // The whole sheet is stretched along y. In one step only its free edges can have contracted.
    model::State state = s.state();
    for (Vec3& x : state.positions) x.y() *= 1.0 + strain;
    s.setState(state);
    run(s, 1);
    EXPECT_EQ(stretchLinksOf(s.model()).size() < links, strain > 0.1) << strain;
  }
}

/// A sheet of 0.3 m, held along an edge. A hand jerks at the other one with 2 m/s.
simulation::SceneParams jerkedSheet(solve::IntegratorType type, double step) {
  simulation::SceneParams p;
  p.cloud.shape = simulation::CloudParams::Shape::kSheet;
  p.cloud.points = 400;
  p.cloud.size = Vec2(0.3, 0.3);
  p.cloud.jitter = 0.2;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.material.young_modulus = 2e4;
  p.material.thickness = 0.003;
  p.material.damping = 1.0;
  p.mass_spring.tear_strain = 0.4;
  p.gravity.setZero();
  p.integrator.type = type;
  p.integrator.time_step = step;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(-0.12, 1.0, 1.0);
  p.pins = {pin};
  tool::ToolParams hand;
  hand.id = "hand";
  hand.mode = tool::Mode::kMove;
  hand.shape.kind = geometry::Solid::Kind::kBox;
  hand.shape.size = Vec3(0.06, 1.0, 0.1);
  hand.path = {{0.0, Vec3(0.15, 0.0, 0.0)}, {0.3, Vec3(0.75, 0.0, 0.0)}};
  p.tools = {hand};
  return p;
}

// The potential -p V of the pressure in a closed surface ends as it opens. That is no gain of energy.
TEST(Tearing, ABallThatBurstsUnderPressureGoesOn) {
  for (const solve::IntegratorType type : {solve::IntegratorType::kVerlet, solve::IntegratorType::kImplicit}) {
    simulation::SceneParams p;
    p.gravity.setZero();
    p.pressure = 300.0;
    p.material.young_modulus = 3e5;
    p.material.thickness = 5e-4;
    p.material.damping = 5.0;
    p.mass_spring.tear_strain = 0.1;
    p.accuracy.estimate = false;
    p.integrator.type = type;
    simulation::Simulation s(p, asCloud(makeSphere(300, 0.1).points));
    const std::size_t links = stretchLinksOf(s.model()).size();
    run(s, 5);
    EXPECT_LT(stretchLinksOf(s.model()).size(), links);
  }
}

/// Links that tear within 0.05 s.
double countTorn(const simulation::SceneParams& p) {
  simulation::Simulation s(p, io::makeShape(p.cloud));
  const double links = static_cast<double>(stretchLinksOf(s.model()).size());
  run(s, static_cast<int>(std::lround(0.05 / p.integrator.time_step)));
  return links - static_cast<double>(stretchLinksOf(s.model()).size());
}

TEST(Tearing, ASheetThatIsJerkedTearsAsFarWithStepsOfAnyLength) {
  for (const solve::IntegratorType type : {solve::IntegratorType::kVerlet, solve::IntegratorType::kImplicit}) {
    const double torn = countTorn(jerkedSheet(type, 0.00125));
    EXPECT_GT(torn, 5.0);
    for (const double step : {0.005, 0.01}) EXPECT_NEAR(countTorn(jerkedSheet(type, step)), torn, 2.0) << step;
  }
}

// Why the error estimate ends.
TEST(Tearing, ATornSurfaceIsNotSaidToBeCut) {
  const auto tell = [](const simulation::SceneParams& p, const cloud::PointCloud& cloud) {
    simulation::Simulation s(p, cloud);
    std::string told;
    for (int k = 0; k < 12; ++k) told += s.step().notice;
    const std::size_t begin = told.find("the surface is "), end = told.find(", which its coarser copies do not follow");
    return begin < end && end != std::string::npos ? told.substr(begin, end - begin) : told;
  };
  simulation::SceneParams torn = jerkedSheet(solve::IntegratorType::kVerlet, 0.005), cut = stillSheet();
  EXPECT_EQ(tell(torn, io::makeShape(torn.cloud)), "the surface is torn");
  EXPECT_EQ(tell(cut, sheetCloud()), "the surface is cut");
  cut.mass_spring.tear_strain = 0.5;
  EXPECT_EQ(tell(cut, sheetCloud()), "the surface is cut or torn");
}

TEST(Cutting, PressureInABallThatIsCutOpenGoesOnWithANotice) {
  const auto tell = [](double pressure) {
    simulation::SceneParams p = stillSheet();
    p.pins.clear();
    p.cloud.shape = simulation::CloudParams::Shape::kSphere;
    p.cloud.points = 400;
    p.cloud.radius = 0.5;
    p.pressure = pressure;
    p.tools[0].shape.size = Vec3(0.002, 0.1, 0.4);
    p.tools[0].path = {{0.0, Vec3(0.0, -0.7, 0.5)}, {0.1, Vec3(0.0, 0.7, 0.5)}};
    simulation::Simulation s(p, io::makeShape(p.cloud));
    Index times = 0;
    for (int k = 0; k < 12; ++k) times += s.step().notice.find("pressure goes on acting") != std::string::npos;
    EXPECT_FALSE(isClosed(s.model()));
    return times;
  };
  EXPECT_EQ(tell(0.01), 1);
  EXPECT_EQ(tell(0.0), 0);
}

// What the pins pulled on is gone at the end of the step. Their work counts, or the steps would seem to gain energy.
TEST(Tearing, PinsThatTearASheetHaveDoneTheirWork) {
  for (const solve::IntegratorType type :
       {solve::IntegratorType::kVerlet, solve::IntegratorType::kSymplecticEuler, solve::IntegratorType::kImplicit})
    for (const double torn_at : {0.03, 0.04})
      for (const double step : {0.002, 0.0025}) {
        simulation::SceneParams p = jerkedSheet(type, step);
        p.tools.clear();
        p.cloud.points = 150;
        p.material.young_modulus = 2e5;
        p.material.thickness = 0.002;
        p.material.density = 300.0;
        p.material.damping = 0.0;
        p.mass_spring.tear_strain = 0.3;
        p.pins[0].region.max.x() = -0.14;
        simulation::PinParams carried;
        carried.region.min = Vec3(0.14, -1.0, -1.0);
        carried.region.max = Vec3(1.0, 1.0, 1.0);
        carried.path = {{0.02, Vec3::Zero()}, {torn_at, Vec3(0.15, 0.0, 0.02)}};
        p.pins.push_back(carried);
        simulation::Simulation s(p, io::makeShape(p.cloud));
        const std::size_t links = stretchLinksOf(s.model()).size();
        for (int k = 0; k < std::lround(0.06 / step); ++k) {
          const simulation::StepOutcome outcome = s.step();
          ASSERT_TRUE(outcome.ok) << static_cast<int>(type) << " " << torn_at << " " << step << " " << outcome.notice;
        }
        EXPECT_LT(stretchLinksOf(s.model()).size(), links);
      }
}

// Half a period of its longest wave after it was stretched the sheet is compressed.
TEST(Tearing, LinksTearThatAreTooLongInTheMiddleOfAStep) {
  simulation::SceneParams p = jerkedSheet(solve::IntegratorType::kVerlet, 0.06);
  p.tools.clear();
  p.pins.clear();
  p.material.damping = 0.0;
  simulation::Simulation s(p, io::makeShape(p.cloud));
  const std::size_t links = stretchLinksOf(s.model()).size();
  model::State state = s.state();
  for (Index i = 0; i < state.size(); ++i) state.velocities[i].x() = 50.0 * state.positions[i].x();
  s.setState(state);
  run(s, 1);
  EXPECT_LT(stretchLinksOf(s.model()).size(), links);
}

TEST(Tearing, WithoutALimitNothingIsCutHoweverFarItIsPulled) {
  simulation::SceneParams p = stillSheet();
  p.tools.clear();
  simulation::Simulation s(p, sheetCloud());
  const std::size_t links = stretchLinksOf(s.model()).size();
  model::State state = s.state();
  for (std::size_t i = 0; i < state.positions.size(); ++i)
    if (!s.pinned()[i]) state.positions[i].x() *= 2.0;
  s.setState(state);
  run(s, 20);
  EXPECT_EQ(stretchLinksOf(s.model()).size(), links);
}

TEST(Cutting, WhatCannotBeCutSaysSo) {
  simulation::SceneParams p = stillSheet();
  EXPECT_EQ(checkParams(p), std::vector<std::string>());
  p.output.resample = true;
  EXPECT_EQ(checkParams(p).size(), 1u);
  p.output.resample = false;
  p.mass_spring.tear_strain = 0.2;
  p.mass_spring.volume_stiffness = 1.0;
  EXPECT_EQ(checkParams(p).size(), 1u);
  p.mass_spring.volume_stiffness = 0.0;
  p.model = "oriented_particles";
  EXPECT_EQ(checkParams(p).size(), 1u);
}

TEST(Blade, GoesBetweenTwoPointsOnOppositeSidesOnly) {
  const geometry::Solid blade = knife(0.01).shape;
  EXPECT_TRUE(tool::isBetween(blade, Vec3(-0.1, 0.0, 0.0), Vec3(0.1, 0.02, 0.0)));
  EXPECT_TRUE(tool::isBetween(blade, Vec3(-0.002, 0.0, 0.0), Vec3(0.1, 0.02, 0.0)));    // inside, nearer to the other side
  EXPECT_FALSE(tool::isBetween(blade, Vec3(0.002, 0.0, 0.0), Vec3(0.1, 0.02, 0.0)));    // inside, on this side
  EXPECT_FALSE(tool::isBetween(blade, Vec3(0.002, 0.0, 0.0), Vec3(0.002, 0.02, 0.0)));  // both inside, on one side
  EXPECT_FALSE(tool::isBetween(blade, Vec3(-0.1, 0.06, 0.0), Vec3(0.1, 0.06, 0.0)));    // beside it
  EXPECT_FALSE(tool::isBetween(blade, Vec3(-0.1, 0.0, 0.0), Vec3(0.0, 0.1, 0.0)));      // past its corner
}

// No stiffness is left, and nothing to build a preconditioner from.
TEST(Cutting, AnEquilibriumOfASurfaceThatIsCutAltogetherEndsInAnAnswer) {
  simulation::SceneParams p = hangingSheet();
  p.mass_spring.tear_strain = 1e-4;
  p.integrator.type = solve::IntegratorType::kStatic;
  p.simplification.target_points = 0;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  simulation::Simulation s(p, sheetCloud(6));
  for (int k = 0; k < 4; ++k) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok || !outcome.problem.empty());
  }
}

}  // namespace
}  // namespace deformable_surface::test
