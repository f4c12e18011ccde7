// What static steps carry out of a scene, because only tools hold it, and these without friction. Private.
#pragma once

#include "deformable_surface/simulation/contact_load.h"
#include "deformable_surface/solve/system.h"

#include <vector>

namespace deformable_surface::simulation {

/// The largest motion, m, in a static step, from before to after (n x 3, m), of parts that nothing but tools holds, if it is many
/// times the size of the scene: that of all points, of the largest tool, and of the way to the farthest one. Else 0. An
/// equilibrium on tools is nearer than that. time, s: at the end of the step. stiffness, N/m, of each point (n): that of the
/// loads that are no tools.
double findCarriedAway(const solve::System& system, const ContactLoad& contact, double time, const std::vector<double>& stiffness,
                       const Points& before, const Points& after);

}  // namespace deformable_surface::simulation
