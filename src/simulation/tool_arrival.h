// How a tool that appears inside a surface reaches its place: from outside. Contact only knows where tools are.
#pragma once

#include "deformable_surface/simulation/contact_load.h"

namespace deformable_surface::simulation {

/// The path plus the offset of the arrival, which decreases linearly to zero.
std::vector<tool::WaypointParams> findArrivingPath(const std::vector<tool::WaypointParams>& path,
                                                   const ContactLoad::Arrival& arrival);

}  // namespace deformable_surface::simulation
