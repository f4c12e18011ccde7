// Choices by the error estimate and by the time of steps: targets are met, or a message says that they are not.
#include "../../src/simulation/accuracy.h"
#include "sagging_strip.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

TEST(AccuracyChoice, HonoursAPositionErrorWithNoMorePointsThanItNeeds) {
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

TEST(AccuracyChoice, SaysOnceWhenTheEstimateGrowsBeyondTheTargetLater) {
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

TEST(AccuracyChoice, SaysThatATargetCannotBeMet) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.accuracy.position_error = 1e-13;
  const Simulation s(p, strip());
  EXPECT_FALSE(s.accuracyChoice().is_met);
  EXPECT_EQ(s.state().size(), strip().size());
  EXPECT_NE(s.accuracyChoice().sentence.find("cannot be met"), std::string::npos) << s.accuracyChoice().sentence;
}

TEST(AccuracyChoice, TakesAllPointsOfASmallCloudHoweverManyStepsAnEquilibriumIsAskedFor) {
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

TEST(AccuracyChoice, IsNotMetWhereTrialsFoundNoBalance) {
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

TEST(AccuracyChoice, FitsATimeBudgetWithTheMostPointsAndSaysWhatThatCosts) {
  SceneParams p = saggingStrip(IntegratorType::kVerlet);
  p.accuracy.step_budget = 100.0;
  const Simulation all(p, strip());
  EXPECT_TRUE(all.accuracyChoice().is_met);
  EXPECT_EQ(all.state().size(), strip().size());
  EXPECT_NE(all.accuracyChoice().sentence.find("bit-identical"), std::string::npos);
  p.accuracy.step_budget = 1e-9;
  const Simulation none(p, strip());
  EXPECT_FALSE(none.accuracyChoice().is_met);
  EXPECT_LT(none.state().size(), all.state().size());
  EXPECT_NE(none.accuracyChoice().sentence.find("cannot be met"), std::string::npos) << none.accuracyChoice().sentence;
}

TEST(AccuracyChoice, TimesNeitherTheFirstStepNorWhatOtherWorkOnTheMachineHoldsUp) {
  int steps = 0;
  const auto step = [&] {
    ++steps;
    return steps == 1 ? 5.0 : steps % 3 == 0 ? 0.1 : 0.001;
  };
  EXPECT_EQ(simulation::timeSteps(step, 0.002), 0.001);
  steps = 0;
  EXPECT_TRUE(std::isinf(simulation::timeSteps([&] { return ++steps < 4 ? 0.001 : INFINITY; }, 0.002)));
}

TEST(AccuracyChoice, TimesASurfaceInMotionWhereThatFits) {
  // Each step costs more than the one before, as where a stretching surface needs finer sub-steps.
  const auto growingFrom = [](double seconds) {
    int steps = 0;
    return [=]() mutable { return seconds * (1.0 + 0.1 * steps++); };
  };
  EXPECT_GT(simulation::timeSteps(growingFrom(0.001), 0.01), 0.0025);
  int steps = 0;
  simulation::timeSteps([&] { return ++steps, 1.0; }, 0.01);
  EXPECT_LT(steps, 10);  // a number that does not fit is not run for long
}

TEST(AccuracyChoice, FillsATimeBudgetByWhatStepsCost) {
  const auto cost = [](Index points) { return 2e-3 * std::pow(points / 1100.0, 1.5); };
  simulation::AccuracyChoice choice;
  const Index points = simulation::chooseByTime(4000, 2e-3, cost, choice);
  EXPECT_GE(points, 1090);
  EXPECT_LE(points, 1100);
  EXPECT_TRUE(choice.is_met);
  EXPECT_EQ(simulation::chooseByTime(900, 2e-3, cost, choice), 900);
  EXPECT_EQ(simulation::chooseByTime(4000, 1e-6, cost, choice), 128);
  EXPECT_FALSE(choice.is_met);
}

TEST(AccuracyChoice, WithoutATargetIsAThousandPoints) {
  const Simulation s(saggingStrip(IntegratorType::kVerlet), sheetCloud(40));
  EXPECT_FALSE(s.accuracyChoice().is_asked);
  EXPECT_EQ(s.accuracyChoice().sentence, "");
  EXPECT_EQ(s.state().size(), 1000);
}

}  // namespace
}  // namespace deformable_surface::test
