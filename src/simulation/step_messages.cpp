#include "step_messages.h"

#include "deformable_surface/base/params.h"
#include "deformable_surface/base/value.h"

namespace deformable_surface::simulation {
namespace {

using solve::IntegratorParams;
using solve::IntegratorType;
using Failure = solve::StepFailure::Kind;

// Why static steps carry away what only tools hold.
constexpr char kSlides[] =
    "along them or past them, since static steps have no friction; pins can hold it, or friction with integrator.type auto";
constexpr double kFar = 0.01;  // of the largest force: above it, more iterations would not help

std::string adviseOnUnbalance(const solve::SolveReport& report, bool is_static, Touch touch) {
  const std::string smaller = "a smaller time_step or ";
  if (touch == Touch::kStopped)
    return report.unbalanced < kFar ? "contact limits the motion of points, which can keep it from a balance"
                                    : "contact limits the motion of points and carries what is unbalanced";
  if (!(report.unbalanced < kFar) && touch == Touch::kTouches && !is_static)
    return "far from balance, as where parts meet or land on a tool within a step: a smaller time_step may help";
  if (!(report.unbalanced < kFar))
    return "far from balance, as under forces that are too large to carry: smaller forces, " +
           (is_static ? "more integrator.max_iterations or " : smaller) + "a reset may help";
  if (report.is_out_of_iterations) return "more integrator.max_iterations or a larger integrator.tolerance end this";
  return std::string("no iteration came nearer, as where a surface folds: a larger integrator.tolerance ends this") +
         (is_static ? "" : ", a smaller time_step may");
}

}  // namespace

std::string describeFailure(const solve::StepFailure& failure) {
  switch (failure.kind) {
    case Failure::kNone: break;
    case Failure::kInterrupted: return "was interrupted";
    case Failure::kTooManySubsteps:
      return "needs " + std::to_string(failure.substeps) + " sub-steps, more than the " + std::to_string(failure.most_substeps) +
             " that are taken at most" + (failure.has_implicit ? " (integrator.type implicit needs none)" : "");
    case Failure::kNotFinite: return "gave values that are not finite";
    case Failure::kLeftSpace: return "moved a point farther than " + formatReal(kMaxLength) + " m from the origin";
    case Failure::kGainedEnergy:
      return "gained energy out of nothing (from " + formatShort(failure.energy_before) + " to " +
             formatShort(failure.energy_after) + " J, though loads and motions did work of " + formatShort(failure.work) +
             " J; together with the steps before it, " + formatShort(failure.excess) + " J too much)";
  }
  return "";
}

std::string describeChange(const solve::TimeMarch::Outcome& outcome, const IntegratorParams& params) {
  if (!outcome.has_changed_type) return "";
  if (outcome.type == IntegratorType::kVerlet && outcome.verlet_substeps <= params.max_substeps)
    return "integrator.type auto: verlet is used again, as its sub-steps are within max_substeps";
  if (outcome.type == IntegratorType::kVerlet)
    return "integrator.type auto: verlet is used: it may need " + std::to_string(outcome.verlet_substeps) +
           " sub-steps per step, more than max_substeps " + std::to_string(params.max_substeps) +
           ", but implicit steps took far more work";
  return "integrator.type auto: verlet may need " + std::to_string(outcome.verlet_substeps) +
         " sub-steps per step, more than max_substeps " + std::to_string(params.max_substeps) + "; implicit is used, which damps";
}

std::string describeRetry(const solve::StepFailure& why, bool is_implicit, Index substeps) {
  return "a step " + describeFailure(why) + ", and was repeated with " +
         (is_implicit ? "the implicit method, which damps" : std::to_string(substeps) + " sub-steps");
}

std::string describeUnbalance(const solve::SolveReport& report, const IntegratorParams& params, bool is_static, Touch touch) {
  const std::string most = "at most integrator.max_iterations, " + std::to_string(params.max_iterations);
  return "the solver stopped after " + std::to_string(report.iterations) + " iterations in all (" + most +
         " in each search) with " + formatShort(report.unbalanced) +
         " of the largest force unbalanced, more than integrator.tolerance, " + formatShort(params.tolerance) + "; " +
         adviseOnUnbalance(report, is_static, touch);
}

std::string describeFallbacks(IntegratorType chosen, Index fallbacks, Index steps) {
  const std::string often = std::to_string(fallbacks) + " of the last " + std::to_string(steps) + " steps ";
  if (chosen == IntegratorType::kVerlet)
    return often + "could not be taken with verlet, and the implicit method, which damps, took them (statistics: fallback_steps)";
  return often +
         "would have gained energy, as where the surface hits something, and implicit Euler took them: it damps more and is less "
         "accurate than the second-order method of integrator.type implicit; verlet has no such steps (statistics: "
         "fallback_steps)";
}

std::string describeCostlySteps(bool is_touched, double iterations, Index verlet_substeps, const IntegratorParams& params) {
  return std::string(is_touched ? "a tool touches, and " : "") + "steps of integrator.type implicit now take " +
         formatShort(iterations) + " iterations each: the " + std::to_string(verlet_substeps) +
         " sub-steps that integrator.type verlet " + (verlet_substeps <= params.max_substeps ? "(or auto) " : "") +
         "needs instead are faster";
}

std::string describeCostlyContact(const std::vector<std::string>& attracting) {
  std::string cause;
  for (const std::string& name : attracting) cause += (cause.empty() ? "; tool " : ", ") + quote(name);
  if (!cause.empty()) cause += " attracts: less strength crumples it less";
  return "contact of the surface with itself takes most of the work of steps: its parts are near each other in very many places" +
         cause + "; fewer simulation points are faster" + (cause.empty() ? "" : ", too");
}

std::string describeRefusal(const solve::StepFailure& failure, IntegratorType chosen, bool has_implicit) {
  std::string advice;
  if (failure.kind == Failure::kGainedEnergy && chosen == IntegratorType::kVerlet)
    advice = std::string("; a smaller integrator.time_step") + (has_implicit ? " or integrator.type auto" : "") + " may help";
  if (failure.kind == Failure::kLeftSpace && chosen == IntegratorType::kStatic)
    advice = std::string(", as what only tools hold does, ") + kSlides;
  return describeFailure(failure) + advice;
}

std::string describeCarriedAway(double way) {
  return "found no equilibrium: what only tools hold moved " + formatShort(way) + " m, " + kSlides;
}

std::string describeDicing(Index points) {
  return "a knife has cut off " + std::to_string(points) +
         " single points in one step: its flat side and the surface move across each other, and it cuts all links on the way; "
         "let an edge lead, or take a shorter blade";
}

std::string describeHalt(const solve::SolveReport& report) {
  return "parts press on each other so hard, or are so fast, that keeping them from crossing took all motion "
         "within them in " +
         std::to_string(report.halted) + " of " + std::to_string(report.substeps) +
         " sub-steps of this step (statistics: halted_steps)";
}

}  // namespace deformable_surface::simulation
