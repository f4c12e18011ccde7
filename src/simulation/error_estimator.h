// The live error estimate: coarser copies of a dynamics run beside it, and how far they are from it and from each other says how
// far it may be from the full surface. Apart from the dynamics, which knows nothing of it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "dent_watch.h"
#include "dynamics.h"

namespace deformable_surface::simulation {

/// Method, calibration and limits: docs/accuracy_control.md.
class ErrorEstimator {
 public:
  /// level: at rest, the dynamics whose error is estimated. Its rest surface has the dense points that its points were chosen
  /// from, and their order of removal. It is not kept. Throws InputError if the copies cannot be built.
  explicit ErrorEstimator(const Dynamics& level);
  /// With forks of the copies.
  ErrorEstimator(const ErrorEstimator& other);

  void reset();

  /// What a snapshot must hold: a run that continues from it has the same estimate, bit for bit.
  struct Memory;
  std::shared_ptr<const Memory> memory() const;
  void setMemory(const Memory& saved);

  /// The same command for every copy. A state that was given to the level they take at the points that they have in common, the
  /// twin disturbed, and what has been seen is forgotten: from now on the estimate is that of what this state becomes. A lost
  /// estimate stays lost.
  void apply(const Command& command);
  void setInterrupt(const std::atomic<bool>* interrupt);
  /// Tools arrive in the copies as they do in the level.
  void adoptArrivals(const ContactLoad& contact);

  /// Only this share of the membrane's stiffness acts in the simulation, which is at rest, and in the copies: what that changes
  /// is no part of the estimate.
  void softenMembrane(double share);
  /// All of it acts again.
  void stiffenMembrane();

  /// The level has slept through a step.
  void pass();

  /// The level has gone to a state that the copies do not know: there is no estimate until the next reset.
  void lose() { seen_.is_lost = true; }

  /// Follows a step that the level has taken. Allocates nothing after the first. Returns a sentence when the estimate becomes
  /// impossible; else nothing. Throws Interrupted if the level's interrupt is true at the end: it is then as if the step had not
  /// been followed.
  std::string follow(const Dynamics& level);

  /// Whether the next equilibrium, the first since the last reset or given state, should be searched for twice: copies of fewer
  /// points may know nothing of others. The second search begins searchDisturbance() (m) from where the first did.
  bool wantsSecondSearch() const {
    return is_simplified_ && !is_body_ && !has_hinged_pins_ && !seen_.has_searched && !seen_.is_lost;
  }
  double searchDisturbance() const;
  /// How far from the first the second search ended, m; infinity: it found none, 0: it was not worth while. As follow().
  std::string learnSecondSearch(double distance);
  /// Whether the last step ended in balance, if it is static: where it did not there is no estimate until one does.
  void learnBalance(bool is_balanced) { seen_.is_unbalanced = !is_balanced; }

  double space() const { return seen_.space; }        // m
  double transfer() const { return seen_.transfer; }  // m
  double time() const { return seen_.time; }          // m
  /// Whether the numbers of points are those for which the estimate is calibrated.
  bool isCalibrated() const { return is_calibrated_; }
  /// Whether the surface may have buckled where its points do not show it since the last reset or given state.
  bool mayBuckle() const { return seen_.may_buckle; }
  /// Their sum, m; infinite where there is no bound, see docs/accuracy_control.md.
  double total() const;

 private:
  template <class Visit>
  void forEachCopy(const Visit& visit);
  void setState(const model::State& state);

  // What has been seen since the last reset.
  struct Seen {
    double space = 0.0, transfer = 0.0, time = 0.0;  // m
    double twin_distance = 0.0;                      // m
    std::uint64_t steps = 0;
    std::uint64_t substeps = 0, shadow_substeps = 0, twin_substeps = 0;  // in steps that all took as they meant to
    bool follows_verlet = false;                                         // verlet_ has taken every step
    bool is_halved = false;  // the method damps, and its twin takes halved steps for want of that
    bool is_lost = false, is_chaotic = false, has_dented = false;
    bool may_buckle = false;                        // chaotic, dented or with others, or nearly so, at any time
    bool is_unbalanced = false;                     // the last equilibrium is none
    bool has_searched = false, has_others = false;  // twice for the first equilibrium; and found more than one
  };

  std::string followStep(const Dynamics& level);
  Dynamics::Outcome step(Dynamics& copy);
  void followVerlet(solve::IntegratorType type);
  bool stepCopies(solve::IntegratorType type, Index substeps);
  // What the twin takes the same steps as: what a method damps cannot tell of chaos.
  const Dynamics& besideTwin() const { return seen_.follows_verlet ? *verlet_ : *shadow_; }
  double measureTime(solve::IntegratorType type) const;
  Buckling judgeBuckling(const Dynamics& level);

  // Constants.
  bool is_body_ = false;                                // see CoarserLevel
  bool is_simplified_ = false;                          // the level has fewer points than the surface
  bool has_hinged_pins_ = false;                        // see RestSurface
  bool is_calibrated_ = false;                          // see isCalibrated()
  double unresolved_ = 1.0;                             // share of the surface's points that are no simulation points
  double step_ = 0.0;                                   // s
  double disturbance_ = 0.0;                            // m, of the twin
  double spacing_ = 0.0, level_spacing_ = 0.0;          // m, of the copies and of the simulation
  std::vector<Index> common_;                           // (m) the level's point that each point of the copies is; -1: none
  std::function<void(const Points&, Points&)> refine_;  // from the copies' points to the level's

  // Copies of fewer points: one like the simulation; one that takes Verlet's steps beside an integrator that damps, as long as
  // they fit; and one from disturbed positions, which takes Verlet's steps, too, or, where they do not fit, finer ones.
  std::unique_ptr<Dynamics> shadow_, twin_, verlet_;

  DentWatch dents_;
  Seen seen_;
  // Before the step that is followed, and the copies that have begun to take it.
  Seen seen_before_;
  std::vector<double> dents_before_;
  std::vector<Dynamics*> stepped_;
  std::optional<DynamicsState> twin_left_;  // of the twin, if it goes on from the shadow in this step
  // Scratch.
  Points coarse_now_, refined_;
};

struct ErrorEstimator::Memory {
  Seen seen;
  std::vector<double> dents;
  DynamicsState shadow, twin;
  std::optional<DynamicsState> verlet;

  std::size_t bytes() const;
};

}  // namespace deformable_surface::simulation
