// The part of a rest surface that scenes with other loads and materials share: what a cloud becomes before any of these act. A
// file of its own because programs keep it from run to run.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

namespace deformable_surface::simulation {

/// The scene with everything at its default that prepareSurface() does not look at. Scenes of which the same is left share their
/// prepared surfaces.
SceneParams keepWhatPrepares(const SceneParams& params);

/// Whether what keepWhatPrepares() leaves is all in what printParams() prints, and the model has a part to share.
bool canShare(const SceneParams& params);

/// Whether trials choose the number of simulation points.
bool hasTarget(const AccuracyParams& accuracy);

/// Down to how many simulation points a simulation of this scene needs the order of removal.
Index findCoarsest(const SceneParams& params);

/// From a cloud up to where the material, the pins and the loads act: a rest surface without a model. It is made of
/// keepWhatPrepares(params) and depends on nothing else of the scene. coarsest: see buildRestSurface(). to_choose: trials will
/// choose the number of simulation points, and there are none yet. Throws InputError.
RestSurface prepareSurface(const SceneParams& params, const cloud::PointCloud& input, Index coarsest, bool to_choose);

/// The surface that buildRestSurface() makes of the cloud and the scene, from what prepareSurface() made of this cloud and a
/// scene that shares it. choose: given if that was to_choose. Throws InputError.
RestSurface buildRestSurface(const SceneParams& params, RestSurface prepared,
                             const std::function<Index(const RestSurface& full)>& choose = nullptr);

}  // namespace deformable_surface::simulation
