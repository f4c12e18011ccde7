// The error estimate covers the true error. A surface that buckles gets no number.
#include "../support/random_scene.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "sagging_strip.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

TEST(ErrorEstimator, SaysForWhichNumbersOfPointsItIsMeantToCover) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  const cloud::PointCloud cloud = strip();
  const Index n = cloud.size();
  const std::pair<Index, bool> expected[] = {{100, false},        {128, true},    {n / 2, true},
                                             {n * 6 / 10, false}, {n - 1, false}, {n, true}};
  for (const auto& [points, is_calibrated] : expected) {
    p.simplification.target_points = points;
    Simulation s(p, cloud);
    EXPECT_EQ(s.statistics().error_calibrated, is_calibrated) << points << " of " << n;
    EXPECT_EQ(s.fork().statistics().error_calibrated, is_calibrated);
  }
  p.accuracy.estimate = false;
  EXPECT_FALSE(Simulation(p, cloud).statistics().error_calibrated);
}

// Scenes of three integrators, and three drawn at random. None is among the scenes that the method was tuned on.
TEST(ErrorEstimate, CoversTheDistanceFromTheFullSurfaceAndIsNotMuchLarger) {
  std::vector<RandomScene> scenes;
  for (IntegratorType type : {IntegratorType::kVerlet, IntegratorType::kStatic, IntegratorType::kImplicit}) {
    scenes.push_back({saggingStrip(type), strip(), "strip"});
    scenes.back().params.simplification.target_points = 150;
  }
  for (std::uint32_t seed : {9002u, 9006u, 9010u}) scenes.push_back(makeRandomScene(seed));
  for (RandomScene& scene : scenes) {
    Simulation s(scene.params, scene.cloud);
    run(s, static_cast<int>(std::lround(scene.params.duration / scene.params.integrator.time_step)));
    const simulation::Statistics statistics = s.statistics();
    const double error = findLargestDistance(s.surface(false).positions, findTruth(scene.params, scene.cloud));
    EXPECT_GT(error, 0.0) << scene.name;
    EXPECT_LE(error, statistics.error_estimate) << scene.name;
    EXPECT_LT(statistics.error_estimate, 15.0 * error) << scene.name;
    EXPECT_NEAR(statistics.error_estimate, statistics.error_space + statistics.error_transfer + statistics.error_time, 1e-12);
    EXPECT_EQ(statistics.error_stiffness, 0.0);
  }
}

TEST(ErrorEstimate, CoversASheetThatFallsOnAnotherOne) {
  SceneParams p;
  p.material.young_modulus = 1e5;
  p.material.damping = 2.0;
  p.contact.self = true;
  p.contact.thickness.is_auto = false;
  p.contact.thickness.value = 0.02;
  simulation::PinParams pin;
  pin.region.min = Vec3(-0.001, -1.0, -0.001);
  pin.region.max = Vec3(0.101, 2.0, 0.001);
  p.pins.push_back(pin);
  pin.region.min.x() = 0.899;
  pin.region.max.x() = 1.001;
  p.pins.push_back(pin);
  p.simplification.target_points = 200;
  p.duration = 0.3;
  const Index n = 21;
  cloud::PointCloud cloud;
  for (const double height : {0.0, 0.15})
    for (Index k = 0; k < n * n; ++k) {
      const double size = height > 0.0 ? 0.7 : 1.0, edge = 0.5 - 0.5 * size;
      cloud.positions.emplace_back(edge + size * (k % n) / (n - 1), edge + size * (k / n) / (n - 1), height);
    }
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  Simulation s(p, cloud);
  run(s, static_cast<int>(std::lround(p.duration / p.integrator.time_step)));
  const simulation::Statistics statistics = s.statistics();
  const double error = findLargestDistance(s.surface(false).positions, findTruth(p, cloud));
  EXPECT_GT(statistics.self_contacts, 0u);
  EXPECT_GT(error, 0.0);
  EXPECT_LE(error, statistics.error_estimate);
  EXPECT_LT(statistics.error_estimate, 25.0 * error);
}

TEST(ErrorEstimate, LeavesEveryBitOfTheResultAsItIs) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.simplification.target_points = 150;
  const Points with = runToShape(p, strip());
  p.accuracy.estimate = false;
  const Points without = runToShape(p, strip());
  for (std::size_t i = 0; i < with.size(); ++i) ASSERT_EQ(with[i], without[i]) << i;
}

// A sheet for which a search from disturbed positions ends in other folds, where a surface of fewer points has none; and the
// strip above, which can only sag.
TEST(ErrorEstimate, IsNoBoundWhereASurfaceHasOtherEquilibria) {
  RandomScene folded = makeRandomScene(11242);
  folded.params.contact.self = false;  // else the first simulation tells that the folds pass through each other
  Simulation s(folded.params, folded.cloud);
  const simulation::Snapshot flat = s.snapshot();
  const std::string notice = s.step().notice;
  EXPECT_NE(notice.find("as where a surface has more than one"), std::string::npos) << notice;
  EXPECT_FALSE(s.statistics().error_bounded);
  // The other equilibrium is a twentieth of a spacing away at least, and the estimate knows it.
  const double spacing = std::sqrt(1.0 / static_cast<double>(s.state().size()));
  const double parts = s.statistics().error_space + s.statistics().error_transfer + s.statistics().error_time;
  EXPECT_TRUE(std::isfinite(s.statistics().error_estimate));
  EXPECT_GT(s.statistics().error_estimate, parts + 0.01 * spacing);
  const double estimate = s.statistics().error_estimate;
  EXPECT_EQ(s.step().notice, "");
  EXPECT_FALSE(s.statistics().error_bounded);  // until the next reset
  const Points positions = s.state().positions;
  s.restore(flat);
  Simulation fork = s.fork();
  EXPECT_EQ(s.step().notice, notice);
  EXPECT_EQ(s.statistics().error_estimate, estimate);  // all digits of where the second search ended
  s.reset();
  setNumThreads(3);
  EXPECT_EQ(s.step().notice, notice);
  EXPECT_EQ(fork.step().notice, notice);
  setNumThreads(0);
  // Searching twice changes nothing.
  SceneParams once = folded.params;
  once.accuracy.estimate = false;
  Simulation without(once, folded.cloud);
  without.step();
  without.step();
  EXPECT_EQ(without.state().positions, positions);
  // If the first search did not converge there is nothing to compare, until one does.
  SceneParams hasty = folded.params;
  hasty.integrator.max_iterations = 3;
  Simulation unbalanced(hasty, folded.cloud);
  EXPECT_EQ(unbalanced.step().notice.find("as where a surface has more than one"), std::string::npos);
  EXPECT_FALSE(unbalanced.statistics().error_bounded);  // nor is what it came to an equilibrium

  SceneParams p = saggingStrip(IntegratorType::kStatic);
  p.simplification.target_points = 150;
  Simulation sagging(p, strip());
  EXPECT_EQ(sagging.step().notice, "");
  EXPECT_TRUE(sagging.statistics().error_bounded);
}

// Pins that clamp the cloud clamp few points, too: the points of a pin that simplification keeps contain its edge.
TEST(ErrorEstimate, CoversAPinThatIsNarrowerThanTheSpacing) {
  SceneParams p = saggingStrip(IntegratorType::kStatic);
  p.simplification.target_points = 80;
  EXPECT_TRUE(Simulation(p, strip()).buildWarnings().empty());
  const double full_spacing = std::sqrt(0.5 * 0.25 / 700.0);
  double end = 1.0;
  for (const Vec3& point : strip().positions) end = std::min(end, point.x());
  p.pins[0].region.max.x() = end + 1.4 * full_spacing;
  Simulation narrow(p, strip());
  EXPECT_TRUE(narrow.buildWarnings().empty());
  narrow.step();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  Simulation all(p, strip());
  all.step();
  const Points few = narrow.surface(false).positions;
  double error = 0.0, sag = 0.0;
  for (std::size_t i = 0; i < few.size(); ++i) {
    error = std::max(error, (few[i] - all.surface(false).positions[i]).norm());
    sag = std::max(sag, (all.surface(false).positions[i] - strip().positions[i]).norm());
  }
  EXPECT_LT(error, 0.05 * sag);
  EXPECT_GE(narrow.statistics().error_estimate, error);
  EXPECT_LT(narrow.statistics().error_estimate, sag);
}

TEST(ErrorEstimate, HasTheSameBitsForEveryNumberOfThreadsAndAfterAReset) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.simplification.target_points = 300;
  const auto estimate = [&](Simulation& s) {
    run(s, 10);
    return s.statistics().error_estimate;
  };
  setNumThreads(1);
  Simulation one(p, strip());
  const double first = estimate(one);
  one.reset();
  EXPECT_EQ(one.statistics().error_estimate, 0.0);
  EXPECT_EQ(estimate(one), first);
  setNumThreads(3);
  Simulation three(p, strip());
  EXPECT_EQ(estimate(three), first);
  setNumThreads(0);
}

TEST(ErrorEstimate, FollowsTheCommandsThatTheSimulationGets) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.simplification.target_points = 150;
  p.gravity.setZero();
  Simulation s(p, strip());
  run(s, 2);
  // Only the twin moves, by up to a thousandth of the spacing along each axis. In a step with one sub-step the factor of the time
  // error makes this four times as large.
  EXPECT_LT(s.statistics().error_estimate, 5e-4);
  s.setGravity(Vec3(0.0, 0.0, -9.81));
  run(s, 20);
  const double sagging = s.statistics().error_estimate;
  // Copies without gravity would be apart by the whole motion.
  double motion = 0.0;
  for (float d : s.surface(false).displacement) motion = std::max(motion, static_cast<double>(d));
  EXPECT_GT(sagging, 2e-4);
  EXPECT_LT(sagging, 0.8 * motion);
}

TEST(ErrorEstimate, WithoutSimplificationIsThatOfTheStepsAlone) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.simplification.method = cloud::SimplificationMethod::kNone;
  Simulation s(p, strip());
  run(s, 20);
  EXPECT_EQ(s.statistics().error_space, 0.0);
  EXPECT_EQ(s.statistics().error_transfer, 0.0);
  EXPECT_GT(s.statistics().error_estimate, 0.0);
  EXPECT_LT(s.statistics().error_estimate, 1e-4);
}

TEST(ErrorEstimate, IsNoNumberWhereItIsSwitchedOff) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.accuracy.estimate = false;
  Simulation s(p, strip());
  run(s, 1);
  const simulation::Statistics statistics = s.statistics();
  EXPECT_TRUE(std::isnan(statistics.error_estimate));
  EXPECT_EQ(std::count(statistics.skipped.begin(), statistics.skipped.end(), "error_estimate"), 1);
}

TEST(ErrorEstimate, OfASheetThatBucklesIsNoBoundAndSaysWhy) {
  // Pushed together in its plane, between clamps, by far more than it can carry.
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.material.bending_rigidity.value = 1e-5;
  p.material.damping = 0.0;
  p.gravity = Vec3(-200.0, 0.0, 0.0);
  p.simplification.target_points = 200;
  Simulation s(p, strip());
  std::string said;
  for (int k = 0; k < 60; ++k) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
    if (outcome.notice.find("error_estimate is no bound") != std::string::npos) said = outcome.notice;
  }
  const simulation::Statistics now = s.statistics();
  EXPECT_FALSE(now.error_bounded);
  EXPECT_TRUE(now.may_buckle);
  // It is a number all the same: twice the copies' distances.
  EXPECT_NEAR(now.error_estimate, 2.0 * (now.error_space + now.error_transfer + now.error_time), 1e-12);
  EXPECT_NE(said.find("buckles"), std::string::npos) << said;
}

// Thin, and its points too few for its dents.
SceneParams thinSphere() {
  SceneParams p;
  p.cloud.shape = simulation::CloudParams::Shape::kSphere;
  p.cloud.points = 1200;
  p.cloud.radius = 0.5;
  p.material.young_modulus = 1e6;
  p.material.thickness = 0.001;
  p.material.density = 500.0;
  p.material.damping = 1.0;
  p.material.bending_rigidity.is_auto = false;
  p.material.bending_rigidity.value = 1e-3;
  p.integrator.type = IntegratorType::kVerlet;
  p.integrator.time_step = 0.005;
  p.simplification.target_points = 150;
  p.gravity.setZero();
  return p;
}

const double kClassicalPressure = 4.0 * std::sqrt(1e3 * 1e-3) / (0.5 * 0.5);  // Pa, of the thin sphere

TEST(ErrorEstimate, OfASphereThatDentsBetweenItsPointsIsNoBoundAndSaysWhy) {
  // Pressed together from outside by three times the classical buckling load, all at once.
  SceneParams p = thinSphere();
  for (double load : {0.2, 3.0}) {
    p.pressure = -load * kClassicalPressure;
    Simulation s(p, io::makeShape(p.cloud));
    std::string said;
    for (int k = 0; k < 20; ++k) said += s.step().notice;
    EXPECT_TRUE(std::isfinite(s.statistics().error_estimate)) << load;
    EXPECT_EQ(s.statistics().error_bounded, load < 1.0) << load;
    EXPECT_EQ(s.statistics().may_buckle, load > 1.0) << load;
    EXPECT_EQ(said.find("dents") != std::string::npos, load > 1.0) << said;
  }
}

TEST(ErrorEstimate, SaysBesideItsNumberThatASphereMayBuckle) {
  SceneParams p = thinSphere();
  const double radius = 0.15;
  const double force = 0.06 * kClassicalPressure * 3.14159 * radius * radius;
  p.forces.push_back({"press", Vec3(0.0, 0.0, 0.5), Vec3(0.0, 0.0, -force), radius, 0.025, 1e300});
  p.duration = 0.1;
  Simulation s(p, io::makeShape(p.cloud));
  run(s, 5);
  EXPECT_FALSE(s.statistics().may_buckle);
  run(s, 5);
  EXPECT_TRUE(s.statistics().may_buckle);
  EXPECT_TRUE(s.statistics().error_bounded);
  const simulation::Snapshot snapshot = s.snapshot();
  s.reset();
  EXPECT_FALSE(s.statistics().may_buckle);
  s.restore(snapshot);
  EXPECT_TRUE(s.statistics().may_buckle);
  // A target that this estimate meets gives the same message.
  p.simplification.target_points = 0;
  p.accuracy.position_error = 0.1;
  p.accuracy.remember = false;
  const Simulation chosen(p, io::makeShape(p.cloud));
  EXPECT_TRUE(chosen.accuracyChoice().is_met);
  EXPECT_NE(chosen.accuracyChoice().sentence.find("may buckle"), std::string::npos) << chosen.accuracyChoice().sentence;
}

TEST(ErrorEstimate, IsANumberFromTheFirstStepBesideATool) {
  // In this scene the copy in finer sub-steps needs no more of them than the other.
  SceneParams p = thinSphere();
  p.material.density = 1000.0;
  p.material.damping = 2.0;
  simulation::PinParams pin;
  pin.region.min = Vec3(-0.6, -0.6, -0.6);
  pin.region.max = Vec3(0.6, 0.6, -0.3);
  p.pins.push_back(pin);
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.kind = geometry::Solid::Kind::kSphere;
  ball.shape.radius = 0.1;
  ball.path.resize(2);
  ball.path[0].position = Vec3(0.0, 0.0, 0.62);
  ball.path[1] = ball.path[0];
  ball.path[1].time = 1.0;
  ball.path[1].position.z() = 0.61;
  p.tools.push_back(ball);
  Simulation s(p, io::makeShape(p.cloud));
  for (int k = 0; k < 3; ++k) {
    run(s, 1);
    EXPECT_TRUE(std::isfinite(s.statistics().error_time)) << k;
    EXPECT_GT(s.statistics().error_time, 0.0) << k;
  }
}

TEST(ErrorEstimate, LooksForBucklingAlsoWhereItsCopiesAreLost) {
  // A knife removes the points that the copies follow before the force presses.
  SceneParams p = thinSphere();
  p.material.density = 1000.0;
  p.material.damping = 2.0;
  tool::ToolParams knife;
  knife.id = "knife";
  knife.mode = tool::Mode::kCut;
  knife.shape.kind = geometry::Solid::Kind::kBox;
  knife.shape.size = Vec3(0.002, 0.1, 0.4);
  knife.path.resize(3);
  knife.path[0].position = Vec3(0.013, 0.7, 0.0);
  knife.path[1].time = 0.04;
  knife.path[1].position = Vec3(0.013, 0.3, 0.0);
  knife.path[2].time = 0.05;
  knife.path[2].position = Vec3(0.013, 0.8, 0.0);
  p.tools.push_back(knife);
  p.forces.push_back({"press", Vec3(0.0, 0.0, 0.5), Vec3(0.0, 0.0, -2.0), 0.15, 0.06, 1e300});
  Simulation s(p, io::makeShape(p.cloud));
  run(s, 11);
  ASSERT_TRUE(std::isinf(s.statistics().error_estimate));
  EXPECT_FALSE(s.statistics().may_buckle);
  run(s, 4);
  EXPECT_TRUE(s.statistics().may_buckle);
}

void expectTheSame(const simulation::Statistics& a, const simulation::Statistics& b) {
  EXPECT_EQ(a.may_buckle, b.may_buckle);
  EXPECT_EQ(a.error_estimate, b.error_estimate);
  EXPECT_EQ(a.error_bounded, b.error_bounded);
  EXPECT_EQ(a.error_space, b.error_space);
  EXPECT_EQ(a.error_transfer, b.error_transfer);
  EXPECT_EQ(a.error_time, b.error_time);
  EXPECT_EQ(a.error_stiffness, b.error_stiffness);
}

TEST(ErrorEstimate, GoesOnBitForBitFromASnapshot) {
  using Type = IntegratorType;
  for (Type type : {Type::kVerlet, Type::kAuto, Type::kImplicit, Type::kStatic}) {
    SceneParams p = saggingStrip(type);
    p.simplification.target_points = 150;
    Simulation s(p, strip());
    run(s, 4);
    s.setForce({"pull", Vec3(0.5, 0.0, 0.0), Vec3(0.0, 0.0, 0.02), 0.1, 0.0, 1e300});
    run(s, 4);
    const simulation::Snapshot snapshot = s.snapshot();
    const simulation::Statistics then = s.statistics();
    ASSERT_TRUE(std::isfinite(then.error_estimate));
    run(s, 6);
    const simulation::Statistics expected = s.statistics();
    EXPECT_GT(expected.error_estimate, 0.0);

    // After other steps, with commands that the copies got, too; and in a new simulation.
    s.setGravity(Vec3(0.0, 30.0, 0.0));
    s.removeForce("pull");
    run(s, 3);
    s.restore(snapshot);
    expectTheSame(s.statistics(), then);
    run(s, 6);
    expectTheSame(s.statistics(), expected);
    Simulation other(p, strip());
    other.restore(snapshot);
    run(other, 6);
    expectTheSame(other.statistics(), expected);
  }
}

TEST(ErrorEstimate, OfImplicitStepsIsFromHalvedOnesWhereVerletsDoNotFitAndSaysSo) {
  SceneParams p = saggingStrip(IntegratorType::kImplicit);
  p.simplification.target_points = 150;
  Simulation by_verlet(p, strip());
  run(by_verlet, 30);
  p.integrator.max_substeps = 1;
  Simulation s(p, strip());
  int times_said = 0;
  for (int k = 0; k < 30; ++k) times_said += s.step().notice.find("steps half as long") != std::string::npos;
  EXPECT_EQ(times_said, 1);
  EXPECT_EQ(s.stateHash(), by_verlet.stateHash());
  // Two ways to compute the same error, each with a safety factor of two.
  EXPECT_GT(s.statistics().error_time, by_verlet.statistics().error_time / 2.0);
  EXPECT_LT(s.statistics().error_time, by_verlet.statistics().error_time * 2.0);
  EXPECT_LE(findLargestDistance(s.surface(false).positions, findTruth(p, strip())), s.statistics().error_estimate);
}

TEST(ErrorEstimate, OfImplicitStepsIsNoBoundWhereVerletsAreChaotic) {
  // A jerk amplifies a disturbance of the full surface more than a thousandfold. Implicit steps damp the waves in which it grows.
  SceneParams p = saggingStrip(IntegratorType::kImplicit);
  p.simplification.target_points = 150;
  p.forces.push_back({"jerk", Vec3(0.5, 0.0, 0.0), Vec3(150.0, 0.0, 0.0), 0.1, 0.05, 1e300});
  Simulation s(p, strip());
  std::string said;
  for (int k = 0; k < 20; ++k) said += s.step().notice;
  EXPECT_FALSE(s.statistics().error_bounded);
  EXPECT_NE(said.find("error_estimate is no bound: two runs"), std::string::npos) << said;
  EXPECT_NE(said.find("began 0.0581 mm apart"), std::string::npos) << said;
}

TEST(ErrorEstimate, SurvivesThatAutoLeavesVerlet) {
  // The strip is pulled so hard that it becomes too stiff for the allowed sub-steps, but not so hard that its motion is chaotic.
  SceneParams p = saggingStrip(IntegratorType::kAuto);
  p.simplification.target_points = 150;
  Simulation s(p, strip());
  run(s, 2);
  const Index before = static_cast<Index>(s.statistics().substeps);
  p.integrator.max_substeps = before + 1;
  p.forces.push_back({"pull", Vec3(0.5, 0.0, 0.0), Vec3(8.0, 0.0, 0.0), 0.1, 0.05, 1e300});
  Simulation pulled(p, strip());
  bool has_left = false;
  for (int k = 0; k < 20; ++k) {
    const simulation::StepOutcome outcome = pulled.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
    has_left = has_left || outcome.notice.find("implicit is used") != std::string::npos;
    EXPECT_EQ(outcome.notice.find("error_estimate is no bound"), std::string::npos) << outcome.notice;
  }
  EXPECT_TRUE(has_left);
  EXPECT_TRUE(pulled.statistics().error_bounded);
}

TEST(ErrorEstimate, BeginsAnewFromAGivenState) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.simplification.target_points = 150;
  Simulation fresh(p, strip());
  const model::State rest = fresh.state();
  run(fresh, 10);
  // At rest, but later: the same steps follow as the first time, including those of the copies.
  Simulation s(p, strip());
  run(s, 5);
  s.setState(rest);
  EXPECT_EQ(s.statistics().error_estimate, 0.0);
  run(s, 10);
  expectTheSame(s.statistics(), fresh.statistics());

  // In the middle of a motion: the estimate covers the distance from a full surface that was given the same state.
  SceneParams all = p;
  all.accuracy.estimate = false;
  all.simplification.method = cloud::SimplificationMethod::kNone;
  Simulation truth(all, strip());
  const Points places = s.surface(false).positions;
  model::State given;
  given.positions = places;
  given.velocities.assign(places.size(), Vec3::Zero());
  truth.setState(given);
  model::State stopped = s.state();
  stopped.velocities.assign(stopped.velocities.size(), Vec3::Zero());
  s.setState(stopped);
  run(s, 10);
  run(truth, 10);
  const double error = findLargestDistance(s.surface(false).positions, truth.surface(false).positions);
  EXPECT_GT(error, 0.0);
  EXPECT_LE(error, s.statistics().error_estimate);
  EXPECT_LT(s.statistics().error_estimate, 25.0 * error);
}

}  // namespace
}  // namespace deformable_surface::test
