// From a cloud to a surface of oriented particles. Private to this model.
#pragma once

#include "deformable_surface/simulation/model_kind.h"

namespace deformable_surface::simulation {

// See ModelKind.
RestSurface prepareParticles(const SceneParams& params, const cloud::PointCloud& input, Index coarsest, bool to_choose);
RestSurface finishParticlesRest(const SceneParams& params, RestSurface prepared, const ModelKind::Choose& choose);
RestSurface makeParticlesTrial(const SceneParams& params, const RestSurface& full, Index points);
CoarserLevel makeParticleCopies(const SceneParams& params, const RestSurface& level);
RestSurface copyCoarserParticles(const SceneParams& params, const RestSurface& of);

}  // namespace deformable_surface::simulation
