// Clouds and scenes that the tests of the simulation share.
#pragma once

#include "../support/surfaces.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/simulation/simulation.h"

namespace deformable_surface::test {

inline cloud::PointCloud asCloud(const Points& points) {
  cloud::PointCloud cloud;
  cloud.positions = points;
  cloud.width = static_cast<std::uint32_t>(points.size());
  return cloud;
}

/// A square sheet of one metre, pinned along x = 0, with damping that brings it to rest in a few seconds.
inline simulation::SceneParams hangingSheet() {
  simulation::SceneParams p;
  p.material.damping = 1.0;
  p.material.bending_rigidity = 1e-4;
  simulation::PinParams pin;
  pin.region.min = Vec3(-0.001, -1.0, -1.0);
  pin.region.max = Vec3(0.001, 1.0, 1.0);
  p.pins.push_back(pin);
  p.simplification.target_points = 150;
  return p;
}

inline cloud::PointCloud sheetCloud(Index n = 30) { return asCloud(makeSheet(n, n, 1.0, 1.0, 0.2).points); }

/// The same without weight, pulled so far that points are inserted.
inline simulation::SceneParams resampledSheet() {
  simulation::SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.output.resample = true;
  p.material.bending_rigidity = 0.0;
  p.forces.push_back({"pull", Vec3(1.0, 0.0, 0.0), Vec3(60.0, 0.0, 0.0), 0.6, 0.0, 1e300});
  return p;
}

/// The problem of a scene or its cloud, or "accepted".
inline std::string problemOf(const simulation::SceneParams& scene, const cloud::PointCloud& cloud) {
  try {
    simulation::Simulation simulation(scene, cloud);
  } catch (const InputError& problem) {
    return problem.what();
  }
  return "accepted";
}

inline void run(simulation::Simulation& s, int steps) {
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = s.step();
    if (!outcome.ok) throw std::runtime_error(outcome.problem);
  }
}

}  // namespace deformable_surface::test
