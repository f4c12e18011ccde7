// A trial of a scene: what its error is estimated to be over its duration, and what that takes. Apart from the choices of what to
// try (accuracy.cpp, integrator_choice.cpp).
#pragma once

#include "deformable_surface/simulation/accuracy_choice.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <limits>
#include <vector>

namespace deformable_surface::simulation {

/// The scene itself on fewer points, with the error estimate that will be published.
struct Probe {
  AccuracyChoice::Candidate candidate;
  bool failed = false;        // the estimate has grown beyond the wish, a step went wrong, or it took more work than was granted
  bool is_cut = false;        // it failed for the work alone: whether it keeps the wish is not known
  double spent = 0.0;         // work that it took as far as it ran; see Candidate::work
  bool is_implicit = false;   // most steps were the implicit method's
  double time_error = 0.0;    // m, the part of the largest estimate that is due to the steps
  std::vector<Points> looks;  // positions at every so many steps
  std::vector<double> apart;  // m, after each step the largest distance so far from those of the probe beside it
};

/// What is tried: the points, the integrator and the share of the membrane's stiffness are those of the candidate. wish: m.
/// beside: a probe of as many points from which the distance is measured, or null. most_work: see Candidate::work; a probe that
/// fails ends there, and its work is then that of the whole duration as far as can be told.
Probe probeError(const SceneParams& params, const RestSurface& full, const AccuracyChoice::Candidate& tried, double wish,
                 const Probe* beside = nullptr, double most_work = std::numeric_limits<double>::infinity());

/// What a Newton iteration on so many points costs, in sub-steps of Verlet's.
double newtonWork(Index points);

}  // namespace deformable_surface::simulation
