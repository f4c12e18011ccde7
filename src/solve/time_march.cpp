#include "deformable_surface/solve/time_march.h"

#include "deformable_surface/base/params.h"
#include "explicit_integrators.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::solve {
namespace {

// Growth of the largest stretch after which the stable step is estimated again: up to kFarStretch, and beyond. Of falling sheets
// of 400 to 4096 points (springs and triangles), the step was at most 1.5 % shorter after 0.05 below a stretch of 0.5, but 15
// to 50 % in triangles stretched to five times their length.
constexpr double kStretchMemory = 0.1, kFarStretchMemory = 0.05;
constexpr double kFarStretch = 0.5;
constexpr double kLoadMemory = 1.1;     // growth of the stiffness of loads, as contacts come, after which it is, too
constexpr double kWider = 1.2;          // by which the stable step must exceed that in use for longer sub-steps to pay
constexpr Index kWideFor = 100;         // steps with less stretch before they are tried: that of a swing comes and goes faster
constexpr double kSmallestShare = 0.1;  // of the safe sub-step in the last retry of a step that was not sound
constexpr double kBold = 1.8;           // of the safe sub-step, which is half of the stable one: smooth motion allows it
// The same near damped contact, which sets in at once. Of twelve undamped blocks that bounce (300 and 343 points), nine lost
// their energy's calm with 1.8, none with 1.6. Twisted strips that jam move 1.5 to 2 times as fast with 1.8.
constexpr double kBoldInContact = 1.6;
// The same where many points were stopped short in the step before. Eight twisted strips of 300 points that jam (one run each)
// take 0.93 of the time that they take with kBoldInContact, with which three of them move about twice as fast.
constexpr double kBoldInJam = 1.35;
// Of the energy in motion and stretch: largest error of the account for bold steps to go on.
constexpr double kCalm = 0.01;
constexpr double kCalmSlow = 0.001;  // the same for outer steps: their resonances then heat the surface by no more
constexpr double kRest = 1e-6;       // of the same in motion: such a surface settles, and outer steps hold it off its balance
// Steps with safe sub-steps before bold ones are tried again: a failed trial then costs 1 %.
constexpr Index kCautious = 100;
// Decay per step of the sums of energy from outer steps and of dissipation: such a balance settles in ten steps.
constexpr double kForget = 0.1;
// Of the recent dissipation: energy from outer steps above it means resonance; a smooth swing shows 0.007.
constexpr double kHeated = 0.1;
constexpr Index kResonant = 1000;   // steps before outer steps are tried again
constexpr Index kMostInner = 8;     // bold sub-steps in which slow forces act once: the others cost the most by then
constexpr double kSlowShare = 0.5;  // of the step of other forces: the energy then oscillates little more
constexpr Index kPortion = 32;      // sub-steps between two looks at the stable step: the look then costs a few per cent
// Parts of an implicit step in which something breaks: others must bear its share, or no longer, before they break, too. In
// jerked sheets of 1000 points with steps of 10 ms as many links tear as with steps of 1.25 ms.
constexpr Index kBreakingParts = 8;
// Auto leaves a method that takes so many times the work of the other: implicit steps after five that take four times the work of
// Verlet's sub-steps.
constexpr double kCostly = 2.0;
// Weight of an implicit step in the mean of their work: of the first one, and of others, as single ones may need many iterations.
constexpr double kLearnFirst = 0.25, kLearn = 0.125;
// Of Verlet's work: an implicit step that comes to more is given up. As the first step in the mean, its work makes auto leave the
// implicit method.
constexpr double kHopelessWork = kCostly / kLearnFirst;
// Of that mean, forgotten in each step by Verlet: after 140 steps or more the implicit method is tried again.
constexpr double kForgetWork = 0.01;
constexpr Index kHopeless = 1000000;  // sub-steps in a step: minutes for small surfaces; the step is refused instead

bool isExplicit(IntegratorType type) {
  return type == IntegratorType::kVerlet || type == IntegratorType::kSymplecticEuler || type == IntegratorType::kExplicitEuler;
}

// The length of sub-steps over that of safe ones.
double findBoldness(const System& system, const TimeMarch::Memory& memory) {
  if (memory.cautious > 0) return 1.0;
  if (memory.was_stopped) return kBoldInJam;
  return system.hasSplitLoads() && memory.loads_at_estimate > 0.0 ? kBoldInContact : kBold;
}

// Work of Verlet's sub-steps over a time (s), in evaluations of all forces. Infinite if they are too many to be taken.
double countVerletPasses(double time, double share, Index most_inner, const System& system, const TimeMarch::Memory& memory) {
  if (countSubsteps(time, share * memory.max_substep) > kHopeless) return std::numeric_limits<double>::infinity();
  return countPasses(chooseSubsteps(time, share * memory.max_substep, kSlowShare * share * memory.max_slow_step,
                                    system.hasSlowForces() ? most_inner : 1));
}

void add(const SolveReport& part, SolveReport& total) {
  total.finite = part.finite;
  total.converged = total.converged && part.converged;
  total.substeps += part.substeps;
  total.stopped += part.stopped;
  total.halted += part.halted;
  total.fallbacks += part.fallbacks;
  total.iterations += part.iterations;
  total.passes += part.passes;
  total.is_quasi_newton = part.is_quasi_newton;
  total.residual = std::max(total.residual, part.residual);
  total.unbalanced = std::max(total.unbalanced, part.unbalanced);
  total.is_out_of_iterations = total.is_out_of_iterations || part.is_out_of_iterations;
  total.time_forces += part.time_forces;
  total.has_broken = total.has_broken || part.has_broken;
  total.released += part.released;
}

}  // namespace

TimeMarch::Memory TimeMarch::memory() const {
  Memory memory = memory_;
  memory.energy = guard_.memory();
  return memory;
}

// Integrators keep nothing between steps except the pattern of their matrix, which the next solution sets anew, and forces that
// belong to the state.
void TimeMarch::setMemory(const Memory& memory) {
  memory_ = memory;
  guard_.setMemory(memory.energy);
  integrators_.clear();
}

void TimeMarch::restart() {
  // Those for oriented points keep forces, and scratch memory that is costly to make anew in each hot step.
  if (!system_.isOriented()) integrators_.clear();
  for (auto& [type, integrator] : integrators_) integrator->forgetForces();
  guard_.restart();
  memory_.estimate_needed = true;
  memory_.max_substep = std::numeric_limits<double>::infinity();
  memory_.wider = 0;
  memory_.was_stopped = false;
  memory_.cautious = memory_.cautious_slow = 0;
  memory_.heated = memory_.dissipated = 0.0;
  memory_.implicit_work = 0.0;
}

void TimeMarch::prepare(double time, const State& state) {
  if (estimatesStableStep()) refreshStableStep(time, state);
}

void TimeMarch::resume() {
  const bool estimate_needed = memory_.estimate_needed;
  const double implicit_work = memory_.implicit_work;
  restart();
  memory_.implicit_work = implicit_work;
  if (estimate_needed) return;
  memory_.estimate_needed = false;
  memory_.max_substep = memory_.stable_step;
}

void TimeMarch::forcesChanged() {
  for (auto& [type, integrator] : integrators_) integrator->forgetForces();
  guard_.elasticityChanged();
  memory_.estimate_needed = true;
}

// Chooses the integrator for this step.
void TimeMarch::chooseIntegrator(Outcome& outcome) {
  IntegratorType wanted = params_.type;
  if (wanted == IntegratorType::kAuto && !system_.hasStiffness()) {
    wanted = IntegratorType::kVerlet;  // there is no implicit method
  } else if (wanted == IntegratorType::kAuto) {
    const Index substeps = countSubsteps(params_.time_step, memory_.max_substep);
    const double share = findBoldness(system_, memory_);
    const double passes = countVerletPasses(params_.time_step, share, most_inner_, system_, memory_);
    const bool fits = substeps <= params_.max_substeps || passes <= worthOfImplicit();
    wanted = fits ? IntegratorType::kVerlet : IntegratorType::kImplicit;
    if (!fits) most_implicit_passes_ = fineness_ * kHopelessWork * passes;
    outcome.has_changed_type = wanted != memory_.type && (!fits || memory_.type == IntegratorType::kImplicit);
    outcome.verlet_substeps = substeps;
  }
  outcome.type = memory_.type = wanted;
}

// Work up to which auto takes Verlet though its sub-steps are more than max_substeps. Each method is left only where it is far
// more work than the other, so that auto keeps to one of them.
double TimeMarch::worthOfImplicit() const {
  return memory_.implicit_work * (memory_.type == IntegratorType::kImplicit ? 1.0 / kCostly : kCostly);
}

// After a step that succeeded.
void TimeMarch::learnImplicitWork() {
  double& work = memory_.implicit_work;
  if (implicit_passes_ > 0.0) {
    work += (work == 0.0 ? kLearnFirst : kLearn) * (implicit_passes_ / fineness_ - work);
  } else {
    work *= 1.0 - kForgetWork;
  }
}

void TimeMarch::computeForcesOnAll(double time, const State& state, Points& forces) const {
  const auto last = integrators_.find(memory_.type);
  if (last != integrators_.end() && last->second->takeLastForces(system_, state, forces)) {
    system_.addLoadsOnAll(time, state, forces);
  } else {
    system_.computeForcesOnAll(time, state, forces);
  }
}

Integrator& TimeMarch::integrator(IntegratorType type) {
  std::unique_ptr<Integrator>& kept = integrators_[type];
  if (!kept) kept = makeIntegrator(type, params_, system_.isOriented());
  kept->setInterrupt(interrupt_);
  return *kept;
}

// Estimates the stable step again when the surface or its loads have become stiffer, as far as the largest stretch tells. Should
// it not, the energy account sees that the old one is too long.
void TimeMarch::refreshStableStep(double time, const State& state) {
  // Bonds between particles change faster than the stretch shows, and their model knows its step at little cost.
  const bool is_oriented = system_.isOriented();
  const double stretch = is_oriented ? 0.0 : maxStretchOf(model_, state);
  const double loads = is_oriented ? 0.0 : system_.loadStiffness(time, state);
  const double stretch_memory = memory_.stretch_at_estimate < kFarStretch ? kStretchMemory : kFarStretchMemory;
  const bool is_known =
      stretch <= memory_.stretch_at_estimate + stretch_memory && loads <= kLoadMemory * memory_.loads_at_estimate;
  has_less_stretch_ = stretch < memory_.stretch_at_estimate - kStretchMemory;
  if (!memory_.estimate_needed && !is_oriented && is_known) return;
  has_less_stretch_ = false;
  memory_.stable_step = findStableStep(time, state);
  memory_.max_substep = std::min(memory_.max_substep, memory_.stable_step);
  memory_.max_slow_step = 2.0 / std::sqrt(stable_step_.slowRate());
  memory_.stretch_at_estimate = stretch;
  memory_.loads_at_estimate = loads;
  memory_.estimate_needed = false;
}

// Verlet keeps its energy over long times only with sub-steps of one length. They become longer only if for a long time they
// could have been much longer, or when the energy account begins anew.
void TimeMarch::lengthenSubsteps(double time, const State& state) {
  const auto isWide = [&] { return memory_.stable_step > kWider * memory_.max_substep; };
  memory_.wider = has_less_stretch_ || isWide() ? memory_.wider + 1 : 0;
  if (memory_.wider < kWideFor) return;
  memory_.wider = 0;
  if (has_less_stretch_) {
    memory_.estimate_needed = true;
    refreshStableStep(time, state);
  }
  if (isWide()) memory_.max_substep = memory_.stable_step;
}

// Advances the state by one step, in fineness_ parts, each with as many sub-steps as a whole step would have.
SolveReport TimeMarch::advance(double time, double share, State& state) {
  if (memory_.type == IntegratorType::kImplicit)
    return advanceImplicitly(time, fineness_ * static_cast<Index>(std::lround(1.0 / share)), state);
  work_ = dissipated_ = 0.0;
  substeps_needed_ = 0;
  is_too_stiff_ = false;
  const double part = params_.time_step / fineness_;
  SolveReport total;
  for (Index k = 0; k < fineness_ && total.finite && substeps_needed_ == 0 && !isInterrupted(); ++k) {
    add(advancePart(time + k * part, part, share / fineness_, state), total);
    if (is_too_stiff_) return advanceImplicitly(time, fineness_, state);
  }
  return total;
}

// The step as it is tried first: where its method has sub-steps, with bold ones, and with outer steps for slow forces, as long as
// they keep the energy.
SolveReport TimeMarch::advanceBoldly(double time, Index most_inner, State& state) {
  is_bold_ = memory_.cautious == 0 && hasSubsteps();
  most_inner_ = is_bold_ ? most_inner : 1;
  return advance(time, is_bold_ ? findBoldness(system_, memory_) : 1.0, state);
}

// Verlet sub-steps, each at most a share of the safe one, are taken in portions. The stable step is checked between
// portions: the surface can change within a long step.
SolveReport TimeMarch::advancePart(double time, double part, double share, State& state) {
  const Index needed = estimatesStableStep() ? countSubsteps(part, share * memory_.max_substep) : 1;
  if (memory_.type == IntegratorType::kSymplecticEuler && needed > kHopeless) {
    substeps_needed_ = needed;
    return {};
  }
  if (memory_.type != IntegratorType::kVerlet) {
    beginPortion(state);
    const SolveReport report = integrator(memory_.type).advance(system_, time, part, share * memory_.max_substep, state);
    work_ += report.carrying_work ? *report.carrying_work + system_.loadWork(time, time + part, portion_start_, state)
             : memory_.type == IntegratorType::kStatic ? system_.estimateStaticWork(time, time + part, portion_start_, state)
                                                       : system_.estimateWork(time, time + part, portion_start_, state);
    followBreaks(report);
    return report;
  }
  SolveReport total;
  double done = 0.0;
  const bool may_be_implicit = params_.type == IntegratorType::kAuto && system_.hasStiffness();
  for (;;) {
    const Index left = countSubsteps(part - done, share * memory_.max_substep);
    // The surface has become too stiff within the step: the whole step has to be taken implicitly.
    is_too_stiff_ = may_be_implicit && total.substeps + left > params_.max_substeps &&
                    total.passes + countVerletPasses(part - done, share, most_inner_, system_, memory_) > worthOfImplicit();
    if (!is_too_stiff_ && left > kHopeless) substeps_needed_ = left;
    if (is_too_stiff_ || substeps_needed_ > 0 || isInterrupted()) return total;
    const double portion = left <= kPortion ? part - done : (part - done) * kPortion / left;
    beginPortion(state);
    Integrator& verlet = integrator(IntegratorType::kVerlet);
    verlet.setSlowStep(kSlowShare * share * memory_.max_slow_step, most_inner_);
    const SolveReport report = verlet.advance(system_, time + done, portion, share * memory_.max_substep, state);
    const double from = time + done;
    work_ += report.carrying_work ? *report.carrying_work + system_.loadWork(from, from + portion, portion_start_, state)
                                  : system_.estimateWork(from, from + portion, portion_start_, state);
    dissipated_ += report.dissipated;
    followBreaks(report);
    add(report, total);
    // What has left space is not taken, and its further sub-steps would only become shorter.
    if (left <= kPortion || !report.finite || !isInSpace(state)) return total;
    done += portion;
    refreshStableStep(time + done, state);
  }
}

// Repeats the whole step from its beginning with the implicit method, in equal parts; in more of them if something breaks.
SolveReport TimeMarch::advanceImplicitly(double time, Index parts, State& state) {
  const SolveReport report = takeImplicitParts(time, parts, state);
  if (!has_broken_ || !report.finite || report.is_given_up || parts >= kBreakingParts || isInterrupted()) return report;
  return takeImplicitParts(time, kBreakingParts, state);
}

SolveReport TimeMarch::takeImplicitParts(double time, Index parts, State& state) {
  const double part = params_.time_step / parts;
  state = before_;
  takeBreaksBack();
  work_ = dissipated_ = 0.0;
  substeps_needed_ = 0;
  SolveReport total;
  for (Index k = 0; k < parts && total.finite && !isInterrupted(); ++k) {
    const double from = time + k * part;
    beginPortion(state);
    Integrator& implicit = integrator(IntegratorType::kImplicit);
    implicit.setMostPasses(most_implicit_passes_ - implicit_passes_);
    SolveReport report = implicit.advance(system_, from, part, 0.0, state);
    implicit_passes_ += report.passes;
    if (report.is_given_up) return report;
    work_ += *report.carrying_work + system_.loadWork(from, from + part, portion_start_, state);
    if (report.finite) report.breakStretched(system_, state);
    followBreaks(report);
    add(report, total);
  }
  return total;
}

// The account of energy counts what is left of the model.
void TimeMarch::followBreaks(const SolveReport& report) {
  if (!report.has_broken) return;
  has_broken_ = true;
  work_ -= report.released;
  memory_.estimate_needed = true;
  // The pattern of its matrix has changed.
  integrators_.erase(IntegratorType::kImplicit);
}

void TimeMarch::takeBreaksBack() {
  if (!has_broken_) return;
  has_broken_ = false;
  system_.breaking()->takeBack();
  integrators_.erase(IntegratorType::kImplicit);
  for (auto& [type, integrator] : integrators_) integrator->forgetForces();
}

// Restores the state before the step. Estimates made during the failed step are void.
void TimeMarch::goBack(double time, State& state) {
  state = before_;
  takeBreaksBack();
  if (!estimatesStableStep()) return;
  memory_.max_substep = max_substep_before_;
  memory_.estimate_needed = true;
  refreshStableStep(time, state);
}

bool TimeMarch::hasSubsteps() const {
  return memory_.type == IntegratorType::kVerlet || memory_.type == IntegratorType::kSymplecticEuler;
}

bool TimeMarch::estimatesStableStep() const {
  return isExplicit(params_.type) || params_.type == IntegratorType::kAuto || system_.isOriented();
}

// As VelocityVerlet does.
bool TimeMarch::splitsLoads() const {
  return !system_.isOriented() && (params_.type == IntegratorType::kVerlet || params_.type == IntegratorType::kAuto);
}

// If damping removes as much as resonances of outer steps add, the energy stays constant and the surface never comes to rest.
void TimeMarch::watchResonance() {
  memory_.heated += guard_.gain() + dissipated_ - kForget * memory_.heated;
  memory_.dissipated += dissipated_ - kForget * memory_.dissipated;
  if (!(dissipated_ > 0.0 && memory_.heated > kHeated * memory_.dissipated)) return;
  memory_.cautious_slow = kResonant;
  memory_.heated = memory_.dissipated = 0.0;
}

bool TimeMarch::isSound(double time, const SolveReport& report, const State& state) {
  if (isInterrupted() || !report.finite || substeps_needed_ > 0 || !isInSpace(state)) return false;
  const double dt = params_.time_step;
  return guard_.accepts(system_, time + dt, state, dt / report.substeps, work_, allowance());
}

EnergyGuard::Allowance TimeMarch::allowance() const {
  if (memory_.type == IntegratorType::kExplicitEuler) return EnergyGuard::kPublished;
  return isExplicit(memory_.type) ? EnergyGuard::kSymplectic : EnergyGuard::kDescending;
}

bool TimeMarch::isInSpace(const State& state) const {
  return std::all_of(state.positions.begin(), state.positions.end(),
                     [](const Vec3& x) { return (x.array().abs() <= kMaxLength).all(); });
}

StepFailure TimeMarch::findFailure(const SolveReport& report, const State& state) const {
  using Kind = StepFailure::Kind;
  StepFailure failure;
  if (isInterrupted()) {
    failure.kind = Kind::kInterrupted;
  } else if (substeps_needed_ > 0) {
    failure.kind = Kind::kTooManySubsteps;
    failure.substeps = substeps_needed_;
    failure.most_substeps = kHopeless;
    failure.has_implicit = !system_.isOriented();
  } else if (!report.finite) {
    failure.kind = Kind::kNotFinite;
  } else if (!isInSpace(state)) {
    failure.kind = Kind::kLeftSpace;
  } else {
    failure.kind = Kind::kGainedEnergy;
    failure.energy_before = guard_.energyBefore();
    failure.energy_after = guard_.energyAfter();
    failure.work = work_;
    failure.excess = guard_.excess();
  }
  return failure;
}

TimeMarch::Outcome TimeMarch::step(double time, State& state) {
  Outcome outcome;
  SolveReport& report = outcome.report;
  const Memory at_begin = memory();
  before_ = state;
  implicit_passes_ = 0.0;
  most_implicit_passes_ = std::numeric_limits<double>::infinity();
  has_broken_ = false;
  guard_.beginStep(system_, time, state);
  if (estimatesStableStep()) {
    refreshStableStep(time, state);
    lengthenSubsteps(time, state);
  }
  max_substep_before_ = memory_.max_substep;
  // Where forces dissipate by an unknown amount, as friction does, the account of energy does not show resonances.
  const bool is_accounted = !system_.mayDissipateInForces(time, params_.time_step, state);
  const Index most_inner = memory_.cautious == 0 && memory_.cautious_slow == 0 && is_accounted ? kMostInner : 1;
  most_inner_ = most_inner;
  chooseIntegrator(outcome);
  report = advanceBoldly(time, most_inner, state);
  most_implicit_passes_ = std::numeric_limits<double>::infinity();
  if (report.is_given_up && !isInterrupted()) {
    outcome.has_changed_type = at_begin.type == IntegratorType::kImplicit || at_begin.implicit_work == 0.0;
    outcome.type = memory_.type = IntegratorType::kVerlet;
    memory_.implicit_work = std::max(memory_.implicit_work, kLearnFirst * implicit_passes_ / fineness_);
    implicit_passes_ = 0.0;
    goBack(time, state);
    report = advanceBoldly(time, most_inner, state);
  }
  bool sound = isSound(time, report, state);
  if (!guard_.isCalm(kCalmSlow) || guard_.isNearRest(kRest)) {
    memory_.cautious_slow = std::max(memory_.cautious_slow, kCautious);
  } else if (memory_.cautious_slow > 0) {
    --memory_.cautious_slow;
  }
  if (most_inner_ > 1 && !isInterrupted()) watchResonance();
  if (is_bold_ && !isInterrupted() && !(sound && guard_.isCalm(kCalm))) {
    most_inner_ = 1;
    memory_.cautious = kCautious;
    goBack(time, state);
    report = advance(time, 1.0, state);
    sound = isSound(time, report, state);
  } else if (memory_.cautious > 0) {
    --memory_.cautious;
  }

  // A failed step is repeated with finer sub-steps or parts, and by auto implicitly in the end.
  const bool can_be_finer = hasSubsteps() || memory_.type == IntegratorType::kImplicit;
  // If there were too many sub-steps, the step was implicit already, and would be again.
  bool was_implicit = is_too_stiff_;
  for (double share = 0.5;
       !sound && !was_implicit && !isInterrupted() && can_be_finer && substeps_needed_ == 0 && share >= kSmallestShare;
       share *= 0.5) {
    // The implicit method does not overshoot: a surface that it carries away is really carried away.
    if (memory_.type == IntegratorType::kImplicit && !isInSpace(state)) break;
    outcome.retried = findFailure(report, state);
    goBack(time, state);
    report = advance(time, share, state);
    sound = isSound(time, report, state);
    was_implicit = is_too_stiff_;
  }
  const bool may_change =
      params_.type == IntegratorType::kAuto && system_.hasStiffness() && memory_.type == IntegratorType::kVerlet;
  for (Index parts = was_implicit ? 2 : 1; !sound && !isInterrupted() && may_change && parts * kSmallestShare <= 1.0;
       parts *= 2) {
    if (was_implicit && !isInSpace(state)) break;
    outcome.retried = findFailure(report, state);
    outcome.is_retried_implicitly = true;
    goBack(time, state);
    report = advanceImplicitly(time, parts, state);
    sound = isSound(time, report, state);
    was_implicit = true;
  }
  if (isInterrupted()) {
    outcome.ok = false;
    outcome.failure = findFailure(report, state);
    state = before_;
    takeBreaksBack();
    setMemory(at_begin);
    return outcome;
  }
  if (!sound) {
    outcome.ok = false;
    outcome.failure = findFailure(report, state);
    goBack(time, state);
    return outcome;
  }
  if (memory_.type == IntegratorType::kVerlet && (is_too_stiff_ || outcome.is_retried_implicitly))
    report.fallbacks = report.substeps;
  if (params_.type == IntegratorType::kAuto) learnImplicitWork();
  memory_.was_stopped = report.stopped > 0;
  guard_.commit();
  return outcome;
}

}  // namespace deformable_surface::solve
