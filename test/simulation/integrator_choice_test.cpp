// With integrator.type auto, an accuracy target also chooses between Verlet's sub-steps and implicit steps: the cheaper one whose
// estimate stays below the target, until the tried scene ends.
#include "../../src/simulation/integrator_choice.h"
#include "../../src/simulation/dynamics.h"
#include "clouds.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

// A stiff plate, clamped at one end. A ball slowly presses down the other. No softer membrane is accepted for it, its sub-steps
// are short, and the motion is slow.
SceneParams pressedPlate() {
  SceneParams p = hangingSheet();
  p.pins[0].region.max[0] = 0.3;
  p.gravity.setZero();
  p.material.young_modulus = 1e10;
  p.material.thickness = 0.01;
  p.material.density = 100.0;
  p.material.bending_rigidity = 100.0;
  p.material.damping = 20.0;
  p.integrator.time_step = 0.02;
  p.integrator.max_substeps = 10000;
  p.simplification = cloud::SimplificationParams();
  p.tools.emplace_back();
  p.tools[0].id = "ball";
  p.tools[0].shape.radius = 0.1;
  const Vec4 upright(0.0, 0.0, 0.0, 1.0);
  p.tools[0].path = {{0.0, Vec3(0.9, 0.5, 0.1001), upright}, {0.1, Vec3(0.9, 0.5, 0.095), upright}};
  p.accuracy.position_error = 0.01;
  p.duration = 0.1;
  return p;
}

// Implicit steps lose more of its swing than the target allows. Verlet needs more sub-steps than max_substeps, and auto takes no
// more: counted in evaluations of the forces, implicit steps are less work. Bending springs act in every sub-step.
SceneParams swingingSheet() {
  SceneParams p = hangingSheet();
  p.mass_spring.bending = model::Bending::kSprings;
  p.material.young_modulus = 1e9;
  p.integrator.time_step = 1.0 / 30.0;
  p.integrator.max_substeps = 2;
  p.simplification = cloud::SimplificationParams();
  p.mass_spring.tear_strain = 10.0;
  p.accuracy.position_error = 0.002;
  p.duration = 0.2;
  return p;
}

cloud::PointCloud sheet() { return sheetCloud(12); }

int countSteps(const SceneParams& p) { return static_cast<int>(std::lround(p.duration / p.integrator.time_step)); }

double findLargestDistance(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

TEST(IntegratorChoice, TakesImplicitStepsWhereTheyKeepTheTargetForLessWork) {
  SceneParams p = pressedPlate();
  Simulation s(p, sheet());
  const simulation::AccuracyChoice& choice = s.accuracyChoice();
  ASSERT_TRUE(choice.is_met) << choice.sentence;
  EXPECT_EQ(choice.integrator, IntegratorType::kImplicit) << choice.sentence;
  EXPECT_NE(choice.sentence.find("integrator implicit, whose trial took"), std::string::npos) << choice.sentence;
  ASSERT_EQ(choice.candidates.size(), 2u);
  EXPECT_LT(choice.candidates[1].work, choice.candidates[0].work);
  run(s, countSteps(p));
  EXPECT_EQ(s.lastIntegrator(), IntegratorType::kImplicit);
  EXPECT_LE(s.statistics().error_estimate, p.accuracy.position_error);

  p.accuracy = simulation::AccuracyParams();
  p.simplification.target_points = choice.points;
  Simulation by_verlet(p, sheet());
  run(by_verlet, countSteps(p));
  // The loss of implicit steps is measured, not only estimated: the points of the copies lie beside the ball.
  EXPECT_GT(s.statistics().error_stiffness, 0.0);
  EXPECT_LE(findLargestDistance(s.state().positions, by_verlet.state().positions), s.statistics().error_stiffness);
  p.simplification.method = cloud::SimplificationMethod::kNone;
  Simulation truth(p, sheet());
  run(truth, countSteps(p));
  EXPECT_EQ(truth.lastIntegrator(), IntegratorType::kVerlet);
  EXPECT_LE(findLargestDistance(s.surface(false).positions, truth.surface(false).positions), s.statistics().error_estimate);
}

TEST(IntegratorChoice, LeavesVerletWhereImplicitStepsWouldLoseMoreThanTheTarget) {
  // Released, it swings. Steps as long as a fifth of its period damp that.
  SceneParams p = pressedPlate();
  p.gravity = Vec3(0.0, 0.0, -9.81);
  p.accuracy.position_error = 3e-4;
  const Simulation s(p, sheet());
  const simulation::AccuracyChoice& choice = s.accuracyChoice();
  EXPECT_TRUE(choice.is_met) << choice.sentence;
  EXPECT_EQ(choice.integrator, IntegratorType::kAuto) << choice.sentence;
  EXPECT_EQ(choice.candidates.back().integrator, IntegratorType::kImplicit);
  EXPECT_GT(choice.candidates.back().error, p.accuracy.position_error);
}

TEST(IntegratorChoice, LeavesVerletWithoutATrialWhereNoImplicitStepCouldBeCheaper) {
  SceneParams p = swingingSheet();
  p.material.young_modulus = hangingSheet().material.young_modulus;
  p.integrator.max_substeps = 1000;
  const Simulation s(p, sheet());
  ASSERT_TRUE(s.accuracyChoice().is_met) << s.accuracyChoice().sentence;
  for (const simulation::AccuracyChoice::Candidate& tried : s.accuracyChoice().candidates)
    EXPECT_EQ(tried.integrator, IntegratorType::kAuto);
}

TEST(IntegratorChoice, TakesMoreSubstepsThanAutoWouldWhereImplicitStepsMissTheTarget) {
  SceneParams p = swingingSheet();
  Simulation s(p, sheet());
  const simulation::AccuracyChoice& choice = s.accuracyChoice();
  ASSERT_TRUE(choice.is_met) << choice.sentence;
  EXPECT_EQ(choice.integrator, IntegratorType::kVerlet);
  EXPECT_NE(choice.sentence.find("max_substeps"), std::string::npos) << choice.sentence;
  run(s, countSteps(p));
  EXPECT_EQ(s.lastIntegrator(), IntegratorType::kVerlet);
  EXPECT_GT(s.dynamics().lastSubsteps(), p.integrator.max_substeps);
}

TEST(IntegratorChoice, TakesMoreSubstepsThanAutoWouldWhereTheyAreLessWorkThanImplicitSteps) {
  SceneParams p = swingingSheet();
  p.accuracy.position_error = 0.2;
  const Simulation s(p, sheet());
  const simulation::AccuracyChoice& choice = s.accuracyChoice();
  ASSERT_TRUE(choice.is_met) << choice.sentence;
  EXPECT_LE(choice.candidates[0].error, p.accuracy.position_error);
  EXPECT_EQ(choice.integrator, IntegratorType::kVerlet);
  EXPECT_NE(choice.sentence.find("of the work of implicit steps"), std::string::npos) << choice.sentence;
}

TEST(IntegratorChoice, IsNotMadeWhereTheSceneNamesOne) {
  SceneParams p = pressedPlate();
  p.integrator.type = IntegratorType::kVerlet;
  Simulation s(p, sheet());
  EXPECT_EQ(s.accuracyChoice().candidates.size(), 1u);
  s.setTool(p.tools[0]);
  run(s, 2);
  EXPECT_EQ(s.lastIntegrator(), IntegratorType::kVerlet);
}

TEST(IntegratorChoice, EndsWithASentenceWhenACommandComesUntilTheNextReset) {
  SceneParams p = pressedPlate();
  Simulation s(p, sheet());
  run(s, 2);
  ASSERT_EQ(s.lastIntegrator(), IntegratorType::kImplicit);
  s.setTool(p.tools[0]);
  const std::string notice = s.step().notice;
  EXPECT_NE(notice.find("integrator.type is auto again: a tool came"), std::string::npos) << notice;
  EXPECT_EQ(s.lastIntegrator(), IntegratorType::kVerlet);
  EXPECT_EQ(s.step().notice, "");
  s.reset();
  run(s, 1);
  EXPECT_EQ(s.lastIntegrator(), IntegratorType::kImplicit);
}

TEST(IntegratorChoice, EndsBeforeTheFirstStepWhenACommandComesThen) {
  SceneParams p = swingingSheet();
  Simulation s(p, sheet());
  s.setGravity(Vec3(0.0, 0.0, -5.0));
  EXPECT_NE(s.step().notice.find("integrator.type is auto again"), std::string::npos);
  EXPECT_EQ(s.lastIntegrator(), IntegratorType::kImplicit);
}

TEST(IntegratorChoice, GoesOnBitForBitFromASnapshotOfEither) {
  SceneParams p = pressedPlate();
  Simulation s(p, sheet());
  run(s, 2);
  const simulation::Snapshot chosen = s.snapshot();
  Simulation fork = s.fork();
  s.setTool(p.tools[0]);
  run(s, 1);
  const simulation::Snapshot by_auto = s.snapshot();
  run(s, 2);
  const std::uint64_t hash = s.stateHash();
  const double error = s.statistics().error_estimate;
  s.restore(chosen);
  run(s, 3);
  run(fork, 3);
  EXPECT_EQ(s.lastIntegrator(), IntegratorType::kImplicit);
  EXPECT_EQ(s.stateHash(), fork.stateHash());
  EXPECT_EQ(s.statistics().error_estimate, fork.statistics().error_estimate);
  s.restore(by_auto);
  run(s, 2);
  EXPECT_EQ(s.stateHash(), hash);
  EXPECT_EQ(s.statistics().error_estimate, error);
}

// The result of a time budget per step: so many points with the method of auto, and so many with implicit steps.
simulation::AccuracyChoice compare(const SceneParams& params, Index points, Index points_of_implicit) {
  simulation::RestSurface full = simulation::buildRestSurface(params, sheet(), 16);
  simulation::AccuracyChoice choice, with_implicit;
  choice.is_met = points > 0;
  choice.points = points;
  with_implicit.is_met = points_of_implicit > 0;
  with_implicit.points = points_of_implicit;
  simulation::compareIntegrators(params, full, IntegratorType::kImplicit, with_implicit, choice);
  return choice;
}

TEST(IntegratorChoice, OfATimePerStepIsWhatLeadsToTheSmallerEstimate) {
  SceneParams swinging = pressedPlate();
  swinging.tools.clear();
  swinging.gravity = Vec3(0.0, 0.0, -9.81);
  swinging.accuracy = simulation::AccuracyParams();
  swinging.accuracy.step_budget = 1.0;
  swinging.simplification.method = cloud::SimplificationMethod::kNone;
  SceneParams slow = swinging;
  slow.material.damping = 1e4;
  // It creeps down: all points with implicit steps are better than some of them with Verlet.
  const simulation::AccuracyChoice all = compare(slow, 128, 144);
  EXPECT_EQ(all.integrator, IntegratorType::kImplicit);
  EXPECT_EQ(all.points, 144);
  EXPECT_NE(all.sentence.find("integrator implicit, whose estimated error"), std::string::npos) << all.sentence;
  // Released, it swings. Implicit steps damp more than the error of few points.
  EXPECT_EQ(compare(swinging, 128, 144).integrator, IntegratorType::kAuto);
}

TEST(IntegratorChoice, OfATimePerStepTakesImplicitStepsWhereTheyAloneFitAndNotForAsFewPoints) {
  SceneParams p = swingingSheet();
  p.accuracy = simulation::AccuracyParams();
  p.accuracy.step_budget = 1.0;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  EXPECT_EQ(compare(p, 0, 128).integrator, IntegratorType::kImplicit);
  EXPECT_EQ(compare(p, 128, 128).integrator, IntegratorType::kAuto);
  EXPECT_EQ(compare(p, 128, 0).integrator, IntegratorType::kAuto);
  // Where tools touch, the error that copies may miss is not compared.
  p = pressedPlate();
  p.accuracy = simulation::AccuracyParams();
  p.accuracy.step_budget = 1.0;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  EXPECT_EQ(compare(p, 128, 144).integrator, IntegratorType::kAuto);
}

TEST(IntegratorChoice, TriesVerletOnlyIfItsSubStepsAreWithinTheBudget) {
  const SceneParams p = swingingSheet();
  simulation::Probe failed;
  failed.candidate.points = 128;
  failed.candidate.error = 2.0 * p.accuracy.position_error;
  failed.time_error = 10.0 * p.accuracy.position_error;  // the steps' damping is what missed the target
  failed.is_implicit = true;
  // Auto has left Verlet, which takes more sub-steps than max_substeps in each step.
  const double least = static_cast<double>(countSteps(p)) * p.integrator.max_substeps * failed.candidate.points;
  for (const double share : {0.5, 2.0}) {
    simulation::AccuracyChoice choice;
    simulation::WorkBudget budget(share * least);
    simulation::Probe probe = failed;
    simulation::buildRestSurface(p, sheetCloud(20), simulation::kCoarsestPoints, [&](const simulation::RestSurface& full) {
      simulation::tryVerlet(p, full, budget, probe, choice);
      return Index{128};
    });
    EXPECT_EQ(choice.candidates.size(), share < 1.0 ? 0u : 1u) << share;
  }
}

}  // namespace
}  // namespace deformable_surface::test
