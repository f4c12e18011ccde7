// The messages of a step for users, one of each kind.
#include "../../src/simulation/step_messages.h"

#include <gtest/gtest.h>

namespace deformable_surface::simulation {
namespace {

using solve::IntegratorParams;
using solve::IntegratorType;
using solve::StepFailure;
using Outcome = solve::TimeMarch::Outcome;

StepFailure makeFailure(StepFailure::Kind kind) {
  StepFailure failure;
  failure.kind = kind;
  failure.substeps = 2000000;
  failure.most_substeps = 1000000;
  failure.has_implicit = true;
  failure.energy_before = 1.0;
  failure.energy_after = 2.5;
  failure.work = 0.5;
  failure.excess = 1.25;
  return failure;
}

TEST(StepMessages, AFailureIsTheEndOfASentence) {
  EXPECT_EQ(describeFailure(StepFailure()), "");
  EXPECT_EQ(describeFailure(makeFailure(StepFailure::Kind::kInterrupted)), "was interrupted");
  EXPECT_EQ(describeFailure(makeFailure(StepFailure::Kind::kNotFinite)), "gave values that are not finite");
  EXPECT_EQ(
      describeFailure(makeFailure(StepFailure::Kind::kGainedEnergy)),
      "gained energy out of nothing (from 1 to 2.5 J, though loads and motions did work of 0.5 J; together with the steps before "
      "it, 1.25 J too much)");
  EXPECT_EQ(describeFailure(makeFailure(StepFailure::Kind::kLeftSpace)).find("moved a point farther than "), 0u);
  StepFailure failure = makeFailure(StepFailure::Kind::kTooManySubsteps);
  EXPECT_EQ(describeFailure(failure),
            "needs 2000000 sub-steps, more than the 1000000 that are taken at most (integrator.type implicit needs none)");
  failure.has_implicit = false;
  EXPECT_EQ(describeFailure(failure), "needs 2000000 sub-steps, more than the 1000000 that are taken at most");
}

TEST(StepMessages, ARefusedStepOfVerletThatGainedEnergyComesWithAdvice) {
  const StepFailure failure = makeFailure(StepFailure::Kind::kGainedEnergy);
  const std::string why = describeFailure(failure);
  EXPECT_EQ(describeRefusal(failure, IntegratorType::kVerlet, true),
            why + "; a smaller integrator.time_step or integrator.type auto may help");
  EXPECT_EQ(describeRefusal(failure, IntegratorType::kVerlet, false), why + "; a smaller integrator.time_step may help");
  EXPECT_EQ(describeRefusal(failure, IntegratorType::kAuto, true), why);
  EXPECT_EQ(describeRefusal(makeFailure(StepFailure::Kind::kInterrupted), IntegratorType::kVerlet, true), "was interrupted");
}

TEST(StepMessages, CostlyImplicitStepsAreSaidWithWhatIsFaster) {
  IntegratorParams params;
  params.max_substeps = 100;
  EXPECT_EQ(describeCostlySteps(true, 14.5, 90, params),
            "a tool touches, and steps of integrator.type implicit now take 14.5 iterations each: the 90 sub-steps that "
            "integrator.type verlet (or auto) needs instead are faster");
  EXPECT_EQ(describeCostlySteps(true, 14.5, 110, params),
            "a tool touches, and steps of integrator.type implicit now take 14.5 iterations each: the 110 sub-steps that "
            "integrator.type verlet needs instead are faster");
  EXPECT_EQ(describeCostlySteps(false, 14.5, 90, params).find("steps of integrator.type implicit now take 14.5 iterations"), 0u);
}

TEST(StepMessages, OfAStepLikeTheLastThereIsNothingToSay) {
  Outcome outcome;
  outcome.type = IntegratorType::kVerlet;
  EXPECT_EQ(describeChange(outcome, IntegratorParams()), "");
}

TEST(StepMessages, AChangeOfTheIntegratorIsSaidBothWays) {
  IntegratorParams params;
  params.max_substeps = 50;
  Outcome outcome;
  outcome.has_changed_type = true;
  outcome.type = IntegratorType::kImplicit;
  outcome.verlet_substeps = 70;
  EXPECT_EQ(
      describeChange(outcome, params),
      "integrator.type auto: verlet may need 70 sub-steps per step, more than max_substeps 50; implicit is used, which damps");
  outcome.type = IntegratorType::kVerlet;
  EXPECT_EQ(describeChange(outcome, params),
            "integrator.type auto: verlet is used: it may need 70 sub-steps per step, more than max_substeps 50, but "
            "implicit steps "
            "took far more work");
  outcome.verlet_substeps = 40;
  EXPECT_EQ(describeChange(outcome, params),
            "integrator.type auto: verlet is used again, as its sub-steps are within max_substeps");
}

TEST(StepMessages, AStepThatWasTakenAgainIsSaidWithItsReason) {
  const StepFailure why = makeFailure(StepFailure::Kind::kNotFinite);
  EXPECT_EQ(describeRetry(why, false, 12), "a step gave values that are not finite, and was repeated with 12 sub-steps");
  EXPECT_EQ(describeRetry(why, true, 12),
            "a step gave values that are not finite, and was repeated with the implicit method, which damps");
}

TEST(StepMessages, ForcesLeftUnbalancedComeWithAdviceForTheirKind) {
  solve::SolveReport report;
  report.converged = false;
  report.iterations = 7;
  const auto adviceOf = [&](bool is_static, Touch touch = Touch::kNone) {
    const std::string notice = describeUnbalance(report, IntegratorParams(), is_static, touch);
    EXPECT_EQ(notice.find("the solver stopped after 7 iterations in all (at most integrator.max_iterations, "), 0u) << notice;
    return notice.substr(notice.find(';') + 2);
  };
  report.unbalanced = 0.5;
  EXPECT_EQ(adviceOf(true),
            "far from balance, as under forces that are too large to carry: smaller forces, more integrator.max_iterations or a "
            "reset may help");
  EXPECT_EQ(adviceOf(true, Touch::kTouches), adviceOf(true));
  EXPECT_EQ(adviceOf(false, Touch::kTouches),
            "far from balance, as where parts meet or land on a tool within a step: a smaller time_step may help");
  report.unbalanced = 0.001;
  EXPECT_EQ(adviceOf(false, Touch::kTouches), adviceOf(false));
  EXPECT_EQ(adviceOf(true), "no iteration came nearer, as where a surface folds: a larger integrator.tolerance ends this");
  EXPECT_EQ(
      adviceOf(false),
      "no iteration came nearer, as where a surface folds: a larger integrator.tolerance ends this, a smaller time_step may");
  report.is_out_of_iterations = true;
  EXPECT_EQ(adviceOf(true), "more integrator.max_iterations or a larger integrator.tolerance end this");
}

// Smaller steps and more iterations ended it in none of the stacks between plates that were tried.
TEST(StepMessages, WhereContactStopsPointsNothingIsAdvised) {
  solve::SolveReport report;
  report.converged = false;
  for (const double unbalanced : {0.5, 0.001}) {
    for (const bool is_out : {false, true}) {
      report.unbalanced = unbalanced;
      report.is_out_of_iterations = is_out;
      const std::string notice = describeUnbalance(report, IntegratorParams(), false, Touch::kStopped);
      EXPECT_NE(notice.find("; contact limits the motion of points"), std::string::npos) << notice;
      for (const char* advice : {"smaller", "more integrator", "larger integrator"})
        EXPECT_EQ(notice.find(advice), std::string::npos) << notice;
    }
  }
}

TEST(StepMessages, FallbacksAreToldWithTheirShareAndCause) {
  EXPECT_EQ(describeFallbacks(IntegratorType::kImplicit, 20, 100).find("20 of the last 100 steps would have gained energy"), 0u);
  EXPECT_EQ(describeFallbacks(IntegratorType::kVerlet, 2, 10).find("2 of the last 10 steps could not be taken with verlet"), 0u);
}

}  // namespace
}  // namespace deformable_surface::simulation
