// The choice between Verlet's sub-steps and implicit steps where a scene asks for an accuracy and leaves the integrator to auto.
// Apart from the choice of the points, because it is made for points that are known (docs/accuracy_control.md).
#pragma once

#include "accuracy_probe.h"

namespace deformable_surface::simulation {

/// Whether it is left to auto, and there are both.
bool mayChooseIntegrator(const SceneParams& params);

/// Where auto's implicit steps cost the wish, though its points keep it: a probe with Verlet's sub-steps however many takes its
/// place if it keeps the wish.
void tryVerlet(const SceneParams& params, const RestSurface& full, Probe& failed, AccuracyChoice& choice);

/// Of a choice that keeps the wish: the other integrator is taken, with all of the stated membrane stiffness, if its trial keeps
/// the wish for less work. first: the trial of auto with the stated membrane. What implicit steps change is measured beside
/// Verlet's of that trial, which coarser copies could miss: a tool between their points moves none of them.
void chooseIntegrator(const SceneParams& params, const RestSurface& full, const Probe& first, AccuracyChoice& choice);

/// Of the choices by time that auto and the other integrator lead to: the other one is taken if its estimated error is smaller,
/// over the first steps of both, or if it alone fits.
void compareIntegrators(const SceneParams& params, const RestSurface& full, solve::IntegratorType other,
                        AccuracyChoice& with_other, AccuracyChoice& choice);

}  // namespace deformable_surface::simulation
