// Checks commands before anything is changed: every refusal is here. Copies of a surface take commands that were checked
// before.
#pragma once

#include "deformable_surface/simulation/commands.h"

namespace deformable_surface::simulation {

class Dynamics;

/// Throws InputError with a sentence for each problem of the command for this surface.
void check(const Command& command, const Dynamics& dynamics);

}  // namespace deformable_surface::simulation
