// Moves the points of a cloud onto the surface behind the sensor noise, and warns of noise. Private.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include <optional>

namespace deformable_surface::simulation {

/// Moves the dense points onto the surface behind the sensor noise, and adds notes and warnings. Returns the viewpoint, if it is
/// known.
std::optional<Vec3> moveOntoSurface(const InputParams& params, const cloud::PointCloud& input, RestSurface& s);

/// Warns of lengths that look like millimetres. The others here do so, too.
void warnOfUnits(RestSurface& s);

/// Warns if a cloud that should fill a body is the noisy image of a surface.
void warnOfNoisyBody(const InputParams& params, const cloud::PointCloud& input, RestSurface& s);

}  // namespace deformable_surface::simulation
