// What is checked of an iso-surface that guides growth before it begins.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/oriented_particles/oriented_particles.h"

namespace deformable_surface::simulation {

/// Refuses a volume that has not been read, and a seed of which more is outside of the iso-surface than inside. Throws
/// InputError.
void requireSeed(const model::GuideParams& guide, const model::State& state);
/// Whether the inside of the iso-surface reaches the border of the grid.
bool reachesBorder(const model::GuideParams& guide);

}  // namespace deformable_surface::simulation
