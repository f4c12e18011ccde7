// What was chosen from the accuracy that a scene asks for, and why: published beside the simulation that it made.
#pragma once

#include "deformable_surface/base/types.h"

#include <string>
#include <vector>

namespace deformable_surface::simulation {

struct AccuracyChoice {
  /// One number of simulation points that was tried.
  struct Candidate {
    Index points = 0;
    double error = 0.0;      // m, largest estimate of the probe as far as it ran; 0 if it was tried for its time
    double step_time = 0.0;  // s of wall time per step; 0 if it was tried for its error
  };

  bool is_asked = false;     // the scene asks for an accuracy or for a time
  bool is_met = false;       // and the choice fulfils it, by estimate or by measurement
  Index points = 0;          // simulation points chosen
  std::vector<Candidate> candidates;  // in the order of trying
  std::string sentence;      // what was chosen and why; empty if nothing was asked
};

}  // namespace deformable_surface::simulation
