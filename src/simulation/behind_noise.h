// The points of a cloud on the surface behind their noise, and what the user is told of it. Private.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include <optional>

namespace deformable_surface::simulation {

/// Moves the dense points onto the surface behind the sensor's noise, and tells. Returns from where they were seen, if that is
/// known.
std::optional<Vec3> moveOntoSurface(const InputParams& params, const cloud::PointCloud& input, RestSurface& s);

/// Warns if a cloud that is to be a body's volume is the noisy image of a surface.
void warnOfNoisyBody(const InputParams& params, const cloud::PointCloud& input, RestSurface& s);

}  // namespace deformable_surface::simulation
