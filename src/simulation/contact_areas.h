// The areas that simulation points stand for in contact with a soft pad.
#pragma once

#include "deformable_surface/simulation/contact_points.h"
#include "deformable_surface/simulation/model_kind.h"

namespace deformable_surface::simulation {

/// At rest. Of a surface: its area by mass; of points with densities of their own by mass over density. Of a body: the area that
/// the triangles of its skin at the point show along the normal of one of them, the mean of all; zero inside. Throws InputError
/// for planar bodies.
ContactPoints::Areas findContactAreas(const SceneParams& params, const RestSurface& rest, const model::DeformableModel& model);

}  // namespace deformable_surface::simulation
