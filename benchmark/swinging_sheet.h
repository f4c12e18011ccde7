// The sheet on which integrators are compared: one square metre pinned along one edge, released level, without damping.
#pragma once

#include "deformable_surface/simulation/simulation.h"

namespace deformable_surface::benchmark {

/// About n points, all of them simulated. Areal density 0.2 kg/m^2, E h = 1000 N/m.
simulation::SceneParams makeSwingingScene(solve::IntegratorType type, double time_step);
cloud::PointCloud makeSwingingSheet(Index n);

}  // namespace deformable_surface::benchmark
