// Choices by the expected error: targets are met, or a message says that they are not.
#include "../../src/simulation/choice_by_error.h"

#include "../../src/simulation/accuracy_probe.h"
#include "deformable_surface/base/error.h"
#include "sagging_strip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

TEST(ChoiceByError, HonoursAPositionErrorWithNoMorePointsThanItNeeds) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  const cloud::PointCloud cloud = strip();
  const Points truth = findTruth(p, cloud);
  Index previous = 0;
  for (double target : {0.1, 0.02}) {
    p.accuracy.position_error = target;
    Simulation s(p, cloud);
    const simulation::AccuracyChoice& choice = s.accuracyChoice();
    EXPECT_TRUE(choice.is_met) << choice.sentence;
    EXPECT_EQ(s.state().size(), choice.points);
    EXPECT_NE(choice.sentence.find(std::to_string(choice.points) + " of "), std::string::npos) << choice.sentence;
    EXPECT_EQ(s.buildNotes().back(), choice.sentence);
    EXPECT_GE(choice.points, previous);
    previous = choice.points;
    run(s, 30);
    EXPECT_LE(s.statistics().error_estimate, target);
    EXPECT_LE(findLargestDistance(s.surface(false).positions, truth), target);
  }
  EXPECT_LT(previous, cloud.size());
}

// The end of the strip sags most.
TEST(ChoiceByError, TakesFewerPointsForTheErrorInARegion) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  const cloud::PointCloud cloud = strip();
  const Points truth = findTruth(p, cloud);
  p.accuracy.position_error = 0.008;
  const Index everywhere = Simulation(p, cloud).accuracyChoice().points;
  p.accuracy.regions.resize(1);
  p.accuracy.regions[0].region.min = Vec3(0.1, -1.0, -1.0);
  p.accuracy.regions[0].region.max = Vec3(0.2, 1.0, 1.0);
  Simulation s(p, cloud);
  const simulation::AccuracyChoice& choice = s.accuracyChoice();
  EXPECT_TRUE(choice.is_met) << choice.sentence;
  EXPECT_LT(choice.points, everywhere) << choice.sentence;
  EXPECT_NE(choice.sentence.find("in accuracy.regions, which hold "), std::string::npos) << choice.sentence;
  run(s, 30);
  const Points& found = s.surface(false).positions;
  double inside = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    if (isInTarget(p.accuracy, cloud.positions[i])) inside = std::max(inside, (found[i] - truth[i]).norm());
  EXPECT_GT(inside, 0.0);
  EXPECT_LE(inside, p.accuracy.position_error);
  // Beside one that holds points as well.
  p.accuracy.regions.push_back(p.accuracy.regions[0]);
  p.accuracy.regions[1].region.max.x() = 0.100001;
  EXPECT_THROW(Simulation(p, cloud), InputError);
}

TEST(ChoiceByError, SaysOnceWhenTheEstimateGrowsBeyondTheTargetLater) {
  // The trial covers only the first hundredth of a second, in which the strip hardly moves.
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.duration = 0.01;
  p.accuracy.position_error = 2e-3;
  Simulation s(p, strip());
  EXPECT_TRUE(s.accuracyChoice().is_met) << s.accuracyChoice().sentence;
  int times_said = 0;
  for (int k = 0; k < 40; ++k) times_said += s.step().notice.find("beyond accuracy.position_error") != std::string::npos;
  EXPECT_GT(s.statistics().error_estimate, p.accuracy.position_error);
  EXPECT_EQ(times_said, 1);
}

TEST(ChoiceByError, SaysThatATargetCannotBeMet) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.accuracy.position_error = 1e-13;
  const Simulation s(p, strip());
  EXPECT_FALSE(s.accuracyChoice().is_met);
  EXPECT_EQ(s.state().size(), strip().size());
  EXPECT_NE(s.accuracyChoice().sentence.find("cannot be met"), std::string::npos) << s.accuracyChoice().sentence;
}

// A soft sheet that swings down and buckles: trials of few points have no bound.
TEST(ChoiceByError, OfAllPointsUntriedSaysWhatIsNotKnownAndInTheEndThatTheTargetWasKept) {
  SceneParams p = hangingSheet();
  p.material = model::MaterialParams();
  p.material.young_modulus = 1e5;
  p.material.thickness = 0.002;
  p.material.density = 300.0;
  p.material.damping = 1.0;
  p.simplification = cloud::SimplificationParams();
  p.duration = 0.5;
  p.accuracy.position_error = 0.03;
  Simulation s(p, sheetCloud(40));
  const simulation::AccuracyChoice& choice = s.accuracyChoice();
  ASSERT_EQ(choice.points, 1600) << choice.sentence;
  EXPECT_FALSE(choice.is_met) << choice.sentence;
  EXPECT_NE(
      choice.sentence.find("all 1600 points simulated; whether they meet it is not known before the run ends, since no trial of "
                           "all points was made: the expected error of fewer was "),
      std::string::npos)
      << choice.sentence;
  EXPECT_EQ(choice.sentence.find("cannot be met"), std::string::npos) << choice.sentence;
  int times_said = 0;
  std::string said;
  for (int k = 0; k < 55; ++k) {
    const std::string notice = s.step().notice;
    if (notice.find("accuracy.position_error, 0.03 m, was met in all ") == std::string::npos) continue;
    ++times_said;
    said = notice;
  }
  EXPECT_EQ(times_said, 1);
  EXPECT_NE(said.find("in all 50 steps, which trials could not tell: the expected error was at most "), std::string::npos)
      << said;
}

// The equilibrium of a clamped plate. Its error falls faster than that of most scenes.
TEST(ChoiceByError, ALargerTargetNeverTakesMorePoints) {
  SceneParams p;
  p.material.young_modulus = 2e6;
  p.material.thickness = 0.004;
  p.material.density = 600.0;
  p.pins.resize(1);
  p.pins[0].region.min = Vec3(-1.0, -1.0, -1.0);
  p.pins[0].region.max = Vec3(-0.17, 1.0, 1.0);
  p.integrator.type = IntegratorType::kStatic;
  p.duration = p.integrator.time_step;
  p.accuracy.remember = false;
  simulation::CloudParams shape;
  shape.shape = simulation::CloudParams::Shape::kSheet;
  shape.points = 2700;
  shape.size = Vec2(0.4, 0.3);
  shape.jitter = 0.2;
  const cloud::PointCloud cloud = io::makeShape(shape);
  Index previous = 0;
  for (double target : {0.1, 0.05, 0.02}) {
    p.accuracy.position_error = target;
    const simulation::AccuracyChoice choice = Simulation(p, cloud).accuracyChoice();
    EXPECT_TRUE(choice.is_met) << choice.sentence;
    EXPECT_GE(choice.points, previous) << choice.sentence;
    previous = choice.points;
  }
  EXPECT_LT(previous, 600);  // half as many do not suffice
}

TEST(ChoiceByError, TakesAllPointsOfASmallCloudHoweverManyStepsAnEquilibriumIsAskedFor) {
  SceneParams p = hangingSheet();
  p.simplification = cloud::SimplificationParams();
  p.material.young_modulus = 1e6;
  p.integrator.type = IntegratorType::kStatic;
  p.duration = 200.0 * p.integrator.time_step;
  p.accuracy.position_error = 1e-5;
  const Simulation s(p, sheetCloud(22));
  const simulation::AccuracyChoice& choice = s.accuracyChoice();
  EXPECT_TRUE(choice.is_met) << choice.sentence;
  EXPECT_EQ(choice.points, 484) << choice.sentence;
  EXPECT_EQ(choice.error, 0.0);
  // All points are what an equilibrium is measured by: they need no trial.
  ASSERT_EQ(choice.candidates.size(), 1u);
  EXPECT_EQ(choice.candidates[0].points, 128);
}

TEST(ChoiceByError, IsNotMetWhereTrialsFoundNoBalance) {
  SceneParams p = saggingStrip(IntegratorType::kStatic);
  p.simplification = cloud::SimplificationParams();
  p.integrator.max_iterations = 1;
  p.duration = 20.0 * p.integrator.time_step;
  p.accuracy.position_error = 0.5;
  const Simulation s(p, sheetCloud(22));
  const simulation::AccuracyChoice& choice = s.accuracyChoice();
  EXPECT_FALSE(choice.is_met) << choice.sentence;
  EXPECT_EQ(choice.sentence.find("the error of the steps is estimated"), std::string::npos) << choice.sentence;
}

TEST(ChoiceByError, DoesNotCountATargetAsMetIfTheFirstTrialTookTooMuchWork) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.accuracy.position_error = 0.1;
  const auto chooseWith = [&](double most_first) {
    simulation::AccuracyChoice choice;
    simulation::buildRestSurface(p, strip(), simulation::findCoarsest(p), [&](const simulation::RestSurface& full) {
      simulation::chooseByError(p, full, choice, most_first);
      return choice.points;
    });
    return choice;
  };
  const simulation::AccuracyChoice whole = chooseWith(simulation::kMostFirst);
  ASSERT_TRUE(whole.is_met) << whole.sentence;
  ASSERT_LT(whole.points, strip().size());
  // The same trial, ended after a third of its work.
  const simulation::AccuracyChoice cut = chooseWith(whole.candidates[0].work / 3.0);
  EXPECT_FALSE(cut.is_met) << cut.sentence;
  EXPECT_EQ(cut.points, strip().size());
  ASSERT_EQ(cut.candidates.size(), 1u);
  EXPECT_EQ(cut.candidates[0].points, whole.candidates[0].points);
  EXPECT_NEAR(cut.candidates[0].work, whole.candidates[0].work, 0.2 * whole.candidates[0].work);  // as if it had not ended
  EXPECT_NE(cut.sentence.find("where the trial of 128 points ended"), std::string::npos) << cut.sentence;
}

}  // namespace
}  // namespace deformable_surface::test
