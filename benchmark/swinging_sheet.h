// The sheets on which methods are compared: one square metre, 0.2 kg/m^2, released level, without damping, held along an edge or
// at two corners.
#pragma once

#include "deformable_surface/simulation/simulation.h"

namespace deformable_surface::benchmark {

/// About n points, all of them simulated. Areal density 0.2 kg/m^2, E h = 1000 N/m.
simulation::SceneParams makeSwingingScene(solve::IntegratorType type, double time_step);
cloud::PointCloud makeSwingingSheet(Index n);

/// In rows of equilateral triangles, the first of which is pinned: that for which a comparison of methods was printed elsewhere.
simulation::SceneParams makeEquilateralScene(double membrane_stiffness, double time_step);
cloud::PointCloud makeEquilateralSheet(Index across, Index along);

/// side x side points that hang from two adjacent ones.
simulation::SceneParams makeHangingScene(double time_step);
cloud::PointCloud makeHangingSheet(Index side);

}  // namespace deformable_surface::benchmark
