// The choice made from a scene's accuracy target, and its reason: published beside the simulation that was built from it.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/solve/integrator_params.h"

#include <memory>
#include <string>
#include <vector>

namespace deformable_surface::simulation {

struct FirstStep;

struct AccuracyChoice {
  /// A number of simulation points that was tried, with an integrator and a share of the membrane's stiffness.
  struct Candidate {
    Index points = 0;
    double error = 0.0;      // m, largest error expected of the probe as far as it ran; 0 if it was tried for its time
    double step_time = 0.0;  // s of wall time per step; 0 if it was tried for its error
    double membrane_share = 1.0;
    solve::IntegratorType integrator = solve::IntegratorType::kAuto;
    double work = 0.0;        // points times sub-steps in all, or an equivalent time; 0 if only its time was measured
    bool may_buckle = false;  // see Statistics
    bool is_bounded = true;   // its estimate was a bound at every step
  };

  bool is_asked = false;        // the scene asks for an accuracy or for a time
  bool is_met = false;          // and the choice fulfils it over the whole duration, by estimate or by measurement
  Index points = 0;             // simulation points chosen
  double membrane_share = 1.0;  // of the stated membrane stiffness, chosen (docs/accuracy_control.md)
  solve::IntegratorType integrator = solve::IntegratorType::kAuto;  // chosen in the place of auto; else that of the scene
  std::vector<double> softening;  // m, by step: how far a point of the trial had been from where it was with the stated membrane
                                  // and verlet; empty if those are taken
  double error = 0.0;  // m, largest error expected by its trial, of untried all points that of the steps; 0 if chosen by time
  double work = 0.0;   // of its trial, as a candidate's
  bool may_buckle = false;                      // in its trial
  std::shared_ptr<const FirstStep> first_step;  // of its trial, for equilibria: the run takes it over; or null
  std::vector<Candidate> candidates;            // in the order of trying
  std::string why_integrator;                   // reason for another integrator than that of auto; else empty
  std::string sentence;                         // the choice and its reason; empty without an accuracy target

  void take(const Candidate& candidate) {
    points = candidate.points;
    membrane_share = candidate.membrane_share;
    integrator = candidate.integrator;
    error = candidate.error;
    work = candidate.work;
    may_buckle = candidate.may_buckle;
  }
};

}  // namespace deformable_surface::simulation
