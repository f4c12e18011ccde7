// Takes a step of the caller: chooses the method and the number of sub-steps, and repeats the step with more care where it
// failed. It knows neither scenes nor clouds, only forces, energies and a state.
#pragma once

#include "deformable_surface/solve/energy_guard.h"
#include "deformable_surface/solve/integrator.h"
#include "deformable_surface/solve/stable_step.h"

#include <atomic>
#include <limits>
#include <map>

namespace deformable_surface::solve {
/// Why what was tried is no step. Numbers alone: whoever shows it makes the sentence.
struct StepFailure {
  enum class Kind { kNone, kInterrupted, kTooManySubsteps, kNotFinite, kLeftSpace, kGainedEnergy };
  Kind kind = Kind::kNone;
  // Of kTooManySubsteps: how many it needs, how many are taken at most, and whether the implicit method could take it.
  Index substeps = 0, most_substeps = 0;
  bool has_implicit = false;
  // Of kGainedEnergy, J: before and after the step, the work done on the surface in between, and the energy gained in excess by
  // the step and those before it.
  double energy_before = 0.0, energy_after = 0.0, work = 0.0, excess = 0.0;
};

/// A step that gives values that are not finite, leaves all bounds or creates energy is repeated with finer sub-steps, then, by
/// `auto`, with the implicit method. If nothing helps, the state stays as it was.
class TimeMarch {
 public:
  /// All are kept by reference: what they say may change between steps.
  TimeMarch(const System& system, const model::DeformableModel& model, const IntegratorParams& params)
      : system_(system), model_(model), params_(params) {}

  /// What a snapshot must hold: a run that continues from it with the same state gives the same bits.
  struct Memory {
    IntegratorType type = IntegratorType::kAuto;
    double stable_step = 0.0;                                      // s, as estimated last
    double max_substep = std::numeric_limits<double>::infinity();  // s, at most that: what sub-steps are cut by
    Index wider = 0;                                               // steps in a row in which it may be too short
    double max_slow_step = 0.0;                                    // s, a stable step of the model's slow forces alone
    double stretch_at_estimate = 0.0;                              // largest stretch when it was estimated, and
    double loads_at_estimate = 0.0;                                // 1/s^2, System::loadStiffness(): contacts come and go
    bool estimate_needed = true;
    bool was_stopped = false;  // many points were, by a limit of motion, in the last step
    Index cautious = 0;        // steps that are still to be taken with safe sub-steps
    Index cautious_slow = 0;   // steps in which slow forces are still to act in every sub-step
    double heated = 0.0;       // J, that outer steps put into the motion of late, and
    double dissipated = 0.0;   // J, what damping by mass took out of it
    // Work of the implicit steps which auto took of late, in evaluations of all forces; 0: there were none.
    double implicit_work = 0.0;
    EnergyGuard::Memory energy;
  };
  Memory memory() const;
  void setMemory(const Memory& memory);

  /// The state, the masses or the model's forces have changed since the end of the last step.
  void restart();
  /// Estimates the stable step of a state from which no step is taken yet.
  void prepare(double time, const State& state);
  /// Another march over the same forces (of a part) has advanced the state: the energy account starts again. The estimated stable
  /// step stays valid as long as it would have.
  void resume();
  /// As restart(), but only for forces and energy, after plastic flow: the account goes on.
  void forcesChanged();
  /// The loads have changed since the last step.
  void loadsChanged() { guard_.loadsChanged(); }

  struct Outcome {
    bool ok = true;
    StepFailure failure;  // of no kind if ok
    SolveReport report;
    // What a user should know of a step that succeeded.
    IntegratorType type = IntegratorType::kAuto;  // how the step was tried first; not kAuto
    // `auto` has changed between verlet and implicit, or has tried an implicit step for the first time and given it up.
    bool has_changed_type = false;
    Index verlet_substeps = 0;           // that verlet needs by estimate, for auto
    StepFailure retried;                 // why the step was taken once more, the last time; of no kind: it was not
    bool is_retried_implicitly = false;  // that time; else with finer sub-steps or parts
  };
  /// Advances the state from time (s) by params.time_step.
  Outcome step(double time, State& state);

  /// System::computeForcesOnAll(), bit for bit, for the state that the last step ended with. Forces that the integrator kept
  /// are not evaluated again.
  void computeForcesOnAll(double time, const State& state, Points& forces) const;

  /// Multiplies the number of sub-steps of every step by n >= 1.
  void setFineness(Index n) { fineness_ = n; }
  /// Once this is true, a step ends between two of its parts, portions of sub-steps or iterations, as a failed one. Null =
  /// never.
  void setInterrupt(const std::atomic<bool>* interrupt) { interrupt_ = interrupt; }
  /// How the last step was taken; not kAuto once there was one.
  IntegratorType lastType() const { return memory_.type; }

  /// The stable step of explicit methods at a state, s.
  double findStableStep(double time, const State& state) { return stable_step_.estimate(time, state, system_, splitsLoads()); }

 private:
  void chooseIntegrator(Outcome& outcome);
  double worthOfImplicit() const;
  void learnImplicitWork();
  Integrator& integrator(IntegratorType type);
  void refreshStableStep(double time, const State& state);
  void lengthenSubsteps(double time, const State& state);
  SolveReport advanceBoldly(double time, Index most_inner, State& state);
  SolveReport advance(double time, double share, State& state);
  SolveReport advancePart(double time, double part, double share, State& state);
  SolveReport advanceImplicitly(double time, Index parts, State& state);
  SolveReport takeImplicitParts(double time, Index parts, State& state);
  void followBreaks(const SolveReport& report);
  void takeBreaksBack();
  void goBack(double time, State& state);
  bool hasSubsteps() const;
  bool estimatesStableStep() const;
  bool splitsLoads() const;
  void watchResonance();
  // Copies the state, with room for what grows within a step, so that no step allocates.
  void beginPortion(const State& state) {
    portion_start_.escaped.reserve(state.escaped.capacity());
    portion_start_ = state;
  }
  bool isSound(double time, const SolveReport& report, const State& state);
  bool isInSpace(const State& state) const;
  EnergyGuard::Allowance allowance() const;
  bool isInterrupted() const { return interrupt_ && *interrupt_; }
  StepFailure findFailure(const SolveReport& report, const State& state) const;

  const System& system_;
  const model::DeformableModel& model_;
  const IntegratorParams& params_;

  std::map<IntegratorType, std::unique_ptr<Integrator>> integrators_;  // those used so far: each keeps its memory
  StableStep stable_step_;
  EnergyGuard guard_;
  Index fineness_ = 1;
  const std::atomic<bool>* interrupt_ = nullptr;
  Memory memory_;  // without the energy, which guard_ has

  // Scratch.
  State before_, portion_start_;
  double max_substep_before_ = 0.0;
  bool has_broken_ = false;        // something, in the step
  bool has_less_stretch_ = false;  // than when the stable step was estimated
  bool is_bold_ = false;           // the step was tried with bold sub-steps
  Index most_inner_ = 1;           // sub-steps in which slow forces may act once
  bool is_too_stiff_ = false;      // for auto: more sub-steps than it takes
  Index substeps_needed_ = 0;      // if there are too many of them to be taken
  double implicit_passes_ = 0.0;   // of the step: work of all that was tried implicitly, in evaluations of all forces
  double most_implicit_passes_ = std::numeric_limits<double>::infinity();  // of these, until the step is given up
  double work_ = 0.0;        // J, put in during the step by loads without a potential
  double dissipated_ = 0.0;  // J, taken out during the step by damping by mass
};

}  // namespace deformable_surface::solve
