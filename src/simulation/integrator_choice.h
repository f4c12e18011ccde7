// Chooses between Verlet sub-steps and implicit steps if a scene has an accuracy target and leaves the integrator to auto.
// The points are known by then (docs/accuracy_control.md).
#pragma once

#include "accuracy_probe.h"

namespace deformable_surface::simulation {

/// Whether the scene leaves it to auto, and the model has both.
bool mayChooseIntegrator(const SceneParams& params);

/// For points that would meet the target but for auto's implicit steps: a probe with Verlet sub-steps, however many, replaces
/// the failed one if it meets the target. budget: of all trials.
void tryVerlet(const SceneParams& params, const RestSurface& full, WorkBudget& budget, Probe& failed, AccuracyChoice& choice);

/// For a choice that meets the target: the other integrator is taken, with all of the stated membrane stiffness, if its trial
/// meets the target with less work. first: the trial of auto with the stated membrane. The error of implicit steps is measured
/// against Verlet's of that trial. Coarser copies could miss it: a tool between their points moves none of them.
void chooseIntegrator(const SceneParams& params, const RestSurface& full, WorkBudget& budget, const Probe& first,
                      AccuracyChoice& choice);

/// For choices by time with auto and with the other integrator: the other one is taken if its estimated error is smaller,
/// over the first steps of both, or if only it fits.
void compareIntegrators(const SceneParams& params, const RestSurface& full, solve::IntegratorType other,
                        AccuracyChoice& with_other, AccuracyChoice& choice);

}  // namespace deformable_surface::simulation
