// From a cloud to an elastic solid. Private to this model.
#pragma once

#include "deformable_surface/model/elastic_solid/point_volumes.h"
#include "deformable_surface/simulation/model_kind.h"

#include "../../rest_parts.h"

namespace deformable_surface::simulation {

// See ModelKind.
RestSurface makeSolidRest(const SceneParams& params, const cloud::PointCloud& input);
CoarserLevel makeSolidCopies(const SceneParams& params, const RestSurface& level);

/// Neighbours, simulation points, model and transfer of a body whose closed surface are the cleaned points: with
/// neighbours along it, and outward normals. Throws InputError. O(n k log n).
void buildFilledSolid(const SceneParams& params, RestSurface& s);

/// The number of simulation points asked for, out of `of`; a threshold is converted.
Index findSolidTarget(const cloud::SimplificationParams& how, Index of);
/// Model, pins and notes on the simulation points s.points. across, outline: see model::ElasticSolid.
void finishSolid(const SceneParams& params, const Lists& neighbors, const std::vector<double>& detours, const Vec3& across,
                 model::Outline outline, RestSurface& s);

}  // namespace deformable_surface::simulation
