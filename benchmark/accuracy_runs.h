// Runs of the scenes for run time against error: final state, time, and reference.
#pragma once

#include "accuracy_scenes.h"

#include <limits>

namespace deformable_surface::benchmark {

struct Setting {
  std::string method;
  solve::IntegratorType type;
  double time_step;  // s
  double tolerance = 1e-6;
  Index max_iterations = 100;
};

/// Where a run ended, in the order of the cloud.
struct Run {
  Points simulated, dense;       // m
  double setup = 0.0;            // s of processor time, from the cloud to the first step
  double cpu = 0.0, wall = 0.0;  // s
  Index substeps = 0;            // of the last step
  bool is_implicit = false;      // the last step
  std::string state = "sound";
};

struct Error {
  double rms = std::numeric_limits<double>::infinity(), largest = rms;
};

Error measureError(const Points& a, const Points& b);

/// level: how many simulation points.
Run run(const AccuracyScene& scene, Index level, const Setting& setting);

/// The limit for a number of simulation points as the time step goes to zero.
struct Reference {
  Points simulated, dense;
  double uncertainty = 0.0;  // m, rms
  double substep = 0.0;      // s, that velocity Verlet takes by itself
};

Reference findReference(const AccuracyScene& scene, Index level);

/// The reference positions of all points: from the closed form, or from the reference of the first level.
Points findTruth(const AccuracyScene& scene, const Reference& first);

}  // namespace deformable_surface::benchmark
