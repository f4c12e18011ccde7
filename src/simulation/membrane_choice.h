// Chooses a softer membrane for an accuracy target: steps then take fewer sub-steps.
#pragma once

#include "accuracy_probe.h"

namespace deformable_surface::simulation {

/// For a choice that meets the target with the stated membrane: a softer one is taken if its trial meets the target with less
/// work. What stretches more by a softer membrane does so in inverse proportion to the stiffness: the first trial tells how soft
/// the second may be. stated: the trial with the stated stiffness, from which the distance counts as an error.
void chooseMembrane(const SceneParams& params, const RestSurface& full, const Probe& stated, WorkBudget& budget,
                    AccuracyChoice& choice);

}  // namespace deformable_surface::simulation
