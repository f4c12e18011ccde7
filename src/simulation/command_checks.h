// What a command may not ask for: every refusal is here, before anything is changed. Apart from what commands do, since copies of
// a surface take commands that were checked.
#pragma once

#include "deformable_surface/simulation/commands.h"

namespace deformable_surface::simulation {

class Dynamics;

/// Throws InputError with a sentence for each problem of the command for this surface.
void check(const Command& command, const Dynamics& dynamics);

}  // namespace deformable_surface::simulation
