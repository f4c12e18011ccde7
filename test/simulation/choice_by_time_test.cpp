// Choices by the time of steps: budgets are met, or a message says that they are not.
#include "../../src/simulation/choice_by_time.h"

#include "sagging_strip.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

TEST(ChoiceByTime, FitsATimeBudgetWithTheMostPointsAndSaysWhatThatCosts) {
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

TEST(ChoiceByTime, TimesNeitherTheFirstStepNorWhatOtherWorkOnTheMachineHoldsUp) {
  int steps = 0;
  const auto step = [&] {
    ++steps;
    return steps == 1 ? 5.0 : steps % 3 == 0 ? 0.1 : 0.001;
  };
  EXPECT_EQ(simulation::timeSteps(step, 0.002), 0.001);
  steps = 0;
  EXPECT_TRUE(std::isinf(simulation::timeSteps([&] { return ++steps < 4 ? 0.001 : INFINITY; }, 0.002)));
}

TEST(ChoiceByTime, TimesASurfaceInMotionWhereThatFits) {
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

TEST(ChoiceByTime, FillsATimeBudgetByWhatStepsCost) {
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

}  // namespace
}  // namespace deformable_surface::test
