// The members of a simulation: a dynamics with its error estimate, and data for display. Private. Implemented in several
// files: commands and steps (simulation.cpp), statistics (simulation_statistics.cpp), snapshots and
// forks (snapshot.cpp).
#pragma once

#include "deformable_surface/simulation/simulation.h"

#include "deformable_surface/base/timer.h"
#include "deformable_surface/simulation/tracking_watch.h"

#include <optional>

#include "deformed_surface.h"
#include "estimated_dynamics.h"
#include "frequent_steps.h"
#include "lasting_notices.h"
#include "passage_watch.h"
#include "stretch_watch.h"

namespace deformable_surface::simulation {

/// The part of a simulation's state beside its dynamics.
struct Looks {
  double softening = 0.0;                                // m
  std::shared_ptr<const CutTransfer::Memory> severed;    // null: nothing
  std::shared_ptr<const transfer::Resampler> resampler;  // null if points are not inserted
  Statistics statistics;
  std::shared_ptr<const LocalErrors> errors;  // null: not wanted
  bool is_estimated = false;
  std::uint64_t surface_revision = 0;
};

struct Snapshot::Contents {
  std::uint64_t scene = 0;  // see Simulation::Impl::identify()
  double time = 0.0;        // s
  bool is_sight = false;    // it is without the parts that only steps need
  DynamicsState dynamics;
  Looks looks;
  std::shared_ptr<const ErrorEstimator::Memory> estimate;  // null: no estimate
};

/// What a fork copies as it is.
struct CopiedByForks {
  std::vector<std::string> notes;
  std::vector<std::string> warnings;  // those of the rest surface, of its contact and of its growth
  std::uint64_t scene_hash = 0;       // of the given scene
  // A trial has shown that the membrane may be softer than stated, or which integrator to take. It is valid until a command
  // comes or its time is over.
  AccuracyChoice choice;
  bool is_target_missed = false;  // said since the last reset
  double largest_error = 0.0;     // m, expected where the target counts, since rest; infinite where the estimate is no bound
  bool is_target_kept = false;    // said since the last reset
  bool was_commanded = false;     // or restored, since the last reset
  TrackingWatch tracking;         // since the last reset
};

struct Simulation::Impl : CopiedByForks {
  const std::shared_ptr<const cloud::PointCloud> shared_input;
  const cloud::PointCloud& input = *shared_input;
  EstimatedDynamics run;
  DeformedSurface surface;

  double softening = 0.0;                // m, effect of the softer membrane so far, in the trial
  std::string trial_notice;              // for the next step: the trial has ended
  LastingNotices lasting;                // since the last reset, fork or snapshot
  FrequentSteps fallbacks;               // to another integrator; since then
  StretchWatch stretched;                // since then
  std::optional<PassageWatch> passages;  // where contact.self: auto is off; a fork has none
  bool is_passage_told = false;          // since the last reset or snapshot
  Index substeps_since_look = 0;         // at passages

  Statistics statistics;
  std::optional<std::uint64_t> measured_revision;  // of the dynamics, that the statistics are of

  bool is_viewer = false, is_estimated_elsewhere = false;  // it takes no steps; the simulation that it shows has an estimate
  std::optional<std::uint64_t> seen_revision;              // of the surface, in the viewer's last sight
  std::shared_ptr<const LocalErrors> seen_errors;          // in it

  Impl(const SceneParams& params, cloud::PointCloud&& cloud, RestSurface&& rest, AccuracyChoice&& chosen);
  /// A fork.
  Impl(const Impl& other, bool to_view);

  Dynamics& dynamics() { return run.dynamics(); }
  const Dynamics& dynamics() const { return run.dynamics(); }

  bool isSelfContactOff() const;
  Changes apply(const Command& command);
  void leaveTrial(const char* how);
  void reset();

  StepOutcome step();
  void finishStep(EstimatedDynamics::Outcome& taken);
  std::string tellWhatLasts(const EstimatedDynamics::Outcome& taken);
  std::string tellTargetKept();
  bool isAtEnd() const;
  std::string tellStretch(const EstimatedDynamics::Outcome& taken);
  std::string tellPassage(const EstimatedDynamics::Outcome& taken);

  static std::uint64_t identify(const RestSurface& rest, const SceneParams& params);
  std::shared_ptr<const Snapshot::Contents> save(bool is_sight) const;
  void restore(const Snapshot::Contents& saved);
  Looks saveLooks() const;
  void restoreLooks(const Looks& saved);

  const Statistics& measure();
  void measureState();
  void readEstimate(Statistics& into) const;
  LocalErrors findLocalErrors() const;
  void listSkipped();
  void countSteps(const EstimatedDynamics::Outcome& taken);
  void takeStatistics(const EstimatedDynamics::Outcome& taken, double seconds);
  const Surface& makeSurface(bool with_normals);
};

}  // namespace deformable_surface::simulation
