// From a cloud to an elastic solid. Private to this model.
#pragma once

#include "deformable_surface/model/elastic_solid/elastic_solid.h"
#include "deformable_surface/simulation/model_kind.h"

#include "../../rest_parts.h"

namespace deformable_surface::simulation {

// See ModelKind.
RestSurface prepareSolid(const SceneParams& params, const cloud::PointCloud& input);
RestSurface finishSolidRest(const SceneParams& params, RestSurface prepared);
CoarserLevel makeSolidCopies(const SceneParams& params, const RestSurface& level);

/// Simulation points, their neighbours and the transfer of a body whose closed surface are the cleaned points: with
/// neighbours along it, and outward normals. Throws InputError. O(n k log n).
void buildFilledSolid(const SceneParams& params, RestSurface& s);

/// Triangles on the outside of a solid in space, counter-clockwise seen from there. They connect points along the body. Throws
/// InputError for planar solids.
std::vector<model::WeightedTriangle> findSolidSkin(const RestSurface& rest, const model::ElasticSolid& solid);

/// The number of simulation points asked for, out of `of`; a threshold is converted.
Index findSolidTarget(const cloud::SimplificationParams& how, Index of);

}  // namespace deformable_surface::simulation
