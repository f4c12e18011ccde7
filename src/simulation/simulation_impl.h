// What a simulation is made of: a dynamics with its error estimate, and what only those need who look at it. Private, and apart
// from the files that implement it: commands and steps (simulation.cpp), statistics (simulation_statistics.cpp), snapshots and
// forks (snapshot.cpp).
#pragma once

#include "deformable_surface/simulation/simulation.h"

#include "deformable_surface/base/timer.h"

#include <optional>

#include "deformed_surface.h"
#include "estimated_dynamics.h"

namespace deformable_surface::simulation {

/// What belongs to a simulation beside its dynamics.
struct Looks {
  double softening = 0.0;                                // m
  std::shared_ptr<const CutTransfer::Memory> severed;    // null: nothing
  std::shared_ptr<const transfer::Resampler> resampler;  // null if points are not inserted
  Statistics statistics;
  bool is_estimated = false;
  std::uint64_t surface_revision = 0;
};

struct Snapshot::Contents {
  std::uint64_t scene = 0;  // see Simulation::Impl::identify()
  double time = 0.0;        // s
  bool is_sight = false;    // it holds nothing that only steps need
  DynamicsState dynamics;
  Looks looks;
  std::shared_ptr<const ErrorEstimator::Memory> estimate;  // null: no estimate
};

struct Simulation::Impl {
  const std::shared_ptr<const cloud::PointCloud> shared_input;
  const cloud::PointCloud& input = *shared_input;
  EstimatedDynamics run;
  DeformedSurface surface;
  std::vector<std::string> notes;
  std::uint64_t scene_hash;  // of what was given

  // A trial has shown that the membrane may be softer than stated, or which integrator to take, until a command comes or its
  // time is over.
  AccuracyChoice choice;
  double softening = 0.0;         // m, what that has changed so far, in the trial
  std::string trial_notice;       // for the next step, that it has ended
  bool is_target_missed = false;  // said since the last reset

  Statistics statistics;
  std::optional<std::uint64_t> measured_revision;  // of the dynamics, that the statistics are of

  bool is_viewer = false, is_estimated_elsewhere = false;  // it takes no steps; what it shows has an estimate
  std::optional<std::uint64_t> seen_revision;              // of the surface, in the sight that a viewer was given last

  Impl(const SceneParams& params, cloud::PointCloud&& cloud, RestSurface&& rest, AccuracyChoice&& chosen);
  /// A fork.
  Impl(const Impl& other, bool to_view);

  Dynamics& dynamics() { return run.dynamics(); }
  const Dynamics& dynamics() const { return run.dynamics(); }

  Changes apply(const Command& command);
  void leaveTrial(const char* how);
  void reset();

  StepOutcome step();
  void finishStep(EstimatedDynamics::Outcome& taken);

  static std::uint64_t identify(const RestSurface& rest, const SceneParams& params);
  std::shared_ptr<const Snapshot::Contents> save(bool is_sight) const;
  void restore(const Snapshot::Contents& saved);
  Looks saveLooks() const;
  void restoreLooks(const Looks& saved);

  const Statistics& measure();
  void measureState();
  void readEstimate(Statistics& into) const;
  void listSkipped();
  void takeStatistics(const EstimatedDynamics::Outcome& taken, double seconds);
  const Surface& makeSurface(bool with_normals);
};

}  // namespace deformable_surface::simulation
