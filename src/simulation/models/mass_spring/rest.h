// From a cloud to a mass-spring surface. Private to this model.
#pragma once

#include "deformable_surface/simulation/model_kind.h"

namespace deformable_surface::simulation {

// See ModelKind.
RestSurface prepareMassSpring(const SceneParams& params, const cloud::PointCloud& input, Index coarsest, bool to_choose);
RestSurface finishMassSpringRest(const SceneParams& params, RestSurface prepared, const ModelKind::Choose& choose);
RestSurface makeMassSpringTrial(const SceneParams& params, const RestSurface& full, Index points);
RestSurface makeCoarserMassSpring(const SceneParams& params, const RestSurface& of, Index target);
CoarserLevel makeMassSpringCopies(const SceneParams& params, const RestSurface& level);
RestSurface copyCoarserMassSpring(const SceneParams& params, const RestSurface& of);

}  // namespace deformable_surface::simulation
