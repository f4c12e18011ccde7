// A trial of a scene: the estimated error over its duration, and its cost. accuracy.cpp and integrator_choice.cpp choose what
// to try.
#pragma once

#include "deformable_surface/simulation/accuracy_choice.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <limits>
#include <vector>

namespace deformable_surface::simulation {

/// The scene itself on fewer points, with the error estimate that will be published.
struct Probe {
  AccuracyChoice::Candidate candidate;
  bool failed = false;        // the estimate exceeds the target, a step failed, or it took more work than granted
  bool is_cut = false;        // it failed only for the work: whether it meets the target is unknown
  double spent = 0.0;         // work done so far; see Candidate::work
  bool is_implicit = false;   // most steps were the implicit method's
  double time_error = 0.0;    // m, the part of the largest estimate that is due to the steps
  std::vector<Points> looks;  // positions at regular intervals of steps
  std::vector<double> apart;  // m, after each step the largest distance so far from the probe beside it
};

/// Runs a candidate: points, integrator and share of the membrane's stiffness. target: of the accuracy, m.
/// beside: a probe of as many points from which the distance is measured, or null. most_work: see Candidate::work. A
/// failed probe stops early; its work is extrapolated to the full duration.
Probe probeError(const SceneParams& params, const RestSurface& full, const AccuracyChoice::Candidate& tried, double target,
                 const Probe* beside = nullptr, double most_work = std::numeric_limits<double>::infinity());

/// Cost of a Newton iteration on so many points, in sub-steps of Verlet.
double newtonWork(Index points);

}  // namespace deformable_surface::simulation
