// The live error estimate: coarser copies of a dynamics run beside it. Their distances from it and from each other give
// an estimate of its distance from the full surface. The dynamics knows nothing of it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "dent_watch.h"
#include "dynamics.h"
#include "tool_depth.h"

namespace deformable_surface::simulation {

/// The sum of the distances between copies is meant to cover the largest error in 95 % of scenes; where it is no bound, this many
/// times the sum is.
constexpr double kUnboundedFactor = 2.0;

/// What forks of an estimator copy as it is.
class CopiedEstimate {
 protected:
  // Observations since the last reset.
  struct Seen {
    double space = 0.0, transfer = 0.0, time = 0.0;  // m
    double twin_distance = 0.0;                      // m
    double depth = 0.0;                              // m, of points in tools
    std::uint64_t steps = 0;
    std::uint64_t substeps = 0, shadow_substeps = 0, twin_substeps = 0;  // in steps that all took as they meant to
    bool follows_verlet = false;                                         // verlet_ has taken every step
    bool is_halved = false;  // the method damps, and its twin takes halved steps for want of that
    bool is_lost = false, is_chaotic = false, has_dented = false;
    bool may_buckle = false;                        // chaotic, dented or with others, or nearly so, at any time
    bool may_end_elsewhere = false;                 // the last equilibrium is of particles that may have buckled
    bool is_unbalanced = false;                     // the last equilibrium is none
    bool has_met = false;                           // parts of the body touch, or have touched
    bool has_unfelt = false;                        // a tool was in the surface and pushed nothing
    bool has_searched = false, has_others = false;  // twice for the first equilibrium; and found more than one
    double others = 0.0;                            // m, how far away the other one is; infinite: it was not found
    double excess = 0.0, far_excess = 0.0;          // work of the copies above twice, and many times, that of the simulation
    bool is_costly = false;                         // a notice has told so
    std::vector<float> apart;                       // (m) m, see apart()
  };

  // Constants.
  bool is_body_ = false;                                // see CoarserLevel
  bool is_simplified_ = false;                          // the level has fewer points than the surface
  bool has_hinged_pins_ = false;                        // see RestSurface
  bool is_calibrated_ = false;                          // see isCalibrated()
  bool is_local_ = false;                               // apart() is wanted
  std::vector<Index> watched_;                          // simulation points that those in accuracy.regions follow
  double unresolved_ = 1.0;                             // share of the surface's points that are no simulation points
  double step_ = 0.0;                                   // s
  double disturbance_ = 0.0;                            // m, of the twin
  double spacing_ = 0.0, level_spacing_ = 0.0;          // m, of the copies and of the simulation
  std::vector<Index> common_;                           // (m) see CoarserLevel
  std::function<void(const Points&, Points&)> refine_;  // from the copies' points to the level's

  DentWatch dents_;
  Seen seen_;
  Points coarse_now_;  // scratch, of the copies' number of points
};

/// Method, calibration and limits: docs/accuracy_control.md.
class ErrorEstimator : private CopiedEstimate {
 public:
  /// level: the dynamics whose error is estimated, at rest. Its rest surface has the dense points that its points were chosen
  /// from, and their order of removal. It is not kept. Throws InputError if the copies cannot be built.
  explicit ErrorEstimator(const Dynamics& level);
  /// With forks of the copies.
  ErrorEstimator(const ErrorEstimator& other);

  void reset();

  /// What a snapshot must hold: a run that continues from it has the same estimate, bit for bit.
  struct Memory;
  std::shared_ptr<const Memory> memory() const;
  void setMemory(const Memory& saved);

  /// Applies the command to every copy. When a state was set, the copies take it at their common points with the level, and the
  /// twin is disturbed; earlier observations are forgotten: from now on the estimate is that of the set state. A lost
  /// estimate stays lost.
  void apply(const Command& command);
  void setInterrupt(const std::atomic<bool>* interrupt);
  /// Tools arrive in the copies as they do in the level.
  void adoptArrivals(const ContactLoad& contact);

  /// At rest: only this share of the membrane's stiffness acts in the simulation and in the copies. The change that this
  /// makes is not part of the estimate.
  void softenMembrane(double share);
  /// The full stiffness acts again.
  void stiffenMembrane();

  /// The level has slept through a step.
  void pass();

  /// The level has a state that the copies do not know: there is no estimate until the next reset.
  void lose() { seen_.is_lost = true; }

  /// Follows a step that the level has taken; ends: which has changed it so that there is no estimate from now on. Allocates
  /// nothing after the first. Returns a sentence when the estimate ceases to be a bound, or to exist; else an empty one. Throws
  /// Interrupted if the level's interrupt is true at the end: the step then counts as not followed.
  std::string follow(const Dynamics& level, const solve::SolveReport& taken, bool ends);

  /// Whether the next equilibrium, the first since the last reset or set state, should be searched for twice: copies of fewer
  /// points may miss other equilibria. The second search starts searchDisturbance() (m) from the start of the first.
  bool wantsSecondSearch() const {
    return is_simplified_ && !is_body_ && !has_hinged_pins_ && !seen_.has_searched && !seen_.is_lost;
  }
  double searchDisturbance() const;
  /// How far from the first the second search ended, m; infinity: it failed, 0: it did not pay. As follow().
  std::string learnSecondSearch(double distance);
  /// Whether the last static step ended in balance. If not, there is no estimate until one does.
  void learnBalance(bool is_balanced) { seen_.is_unbalanced = !is_balanced; }

  double space() const { return seen_.space; }        // m
  double transfer() const { return seen_.transfer; }  // m
  double time() const { return seen_.time; }          // m
  double others() const { return seen_.others; }      // m, how far away another equilibrium is
  /// If params.output.error: (m) m, how far each simulation point is from where it would follow the copy. Else empty.
  const std::vector<float>& apart() const { return seen_.apart; }
  /// Whether the estimate is calibrated for these numbers of points.
  bool isCalibrated() const { return is_calibrated_; }
  /// Whether the surface may have buckled since the last reset or set state where its points do not show it.
  bool mayBuckle() const { return seen_.may_buckle; }
  /// What they are calibrated for is not the case: small differences grow, or the last step ended out of balance. The estimate is
  /// then kUnboundedFactor times what it would be with a bound, and none. See docs/accuracy_control.md.
  bool isBounded() const;
  /// Their sum, m, without a bound times kUnboundedFactor; infinite where nothing can be said.
  double total() const;
  /// The same of the points in params.accuracy.regions. Without regions it is total().
  double inRegions() const;

 private:
  template <class Visit>
  void forEachCopy(const Visit& visit);
  void setState(const model::State& state);

  std::string followStep(const Dynamics& level, const solve::SolveReport& taken);
  void followPlaces(const Dynamics& level, double lasting);
  std::pair<Dynamics::Outcome, Dynamics::Outcome> stepBoth(Dynamics& a, Dynamics& b);
  void followVerlet(solve::IntegratorType type);
  std::string stepCopies(solve::IntegratorType type, Index substeps);
  // The copy that takes the same kind of steps as the twin: a damping method cannot show chaos.
  const Dynamics& besideTwin() const { return seen_.follows_verlet ? *verlet_ : *shadow_; }
  double measureTime(solve::IntegratorType type) const;
  double boundFactor() const { return isBounded() ? 1.0 : kUnboundedFactor; }
  Buckling judgeBuckling(const Dynamics& level);
  void followWork(const Dynamics& level, const solve::SolveReport& taken);
  std::string describeCost();
  std::string followTools(const Dynamics& level, double lasting);
  std::string followMeeting(const Dynamics& level);

  // Copies of fewer points: one like the simulation; one with Verlet steps, beside an integrator that damps, as long as
  // they fit; and one from disturbed positions, also with Verlet steps or, where they do not fit, with finer ones.
  std::unique_ptr<Dynamics> shadow_, twin_, verlet_;

  std::unique_ptr<ToolDepth> depth_;  // null: there was no tool yet
  // State before the followed step, and the copies that have begun to take it.
  Seen seen_before_;
  std::vector<double> dents_before_;
  std::vector<Dynamics*> stepped_;
  std::optional<DynamicsState> twin_left_;  // of the twin, if it goes on from the shadow in this step
  // Scratch.
  Points refined_;
  double copies_work_ = 0.0, times_own_ = 0.0;  // of the last two copies that took a step at once; over that of the simulation
};

struct ErrorEstimator::Memory {
  Seen seen;
  std::vector<double> dents;
  DynamicsState shadow, twin;
  std::optional<DynamicsState> verlet;

  std::size_t bytes() const;
};

}  // namespace deformable_surface::simulation
