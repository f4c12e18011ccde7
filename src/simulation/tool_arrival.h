// How a tool that appears in a surface comes to its place: from outside. Apart from contact, which only knows where tools are.
#pragma once

#include "deformable_surface/simulation/contact_load.h"

namespace deformable_surface::simulation {

/// The path with the offset that the arrival has at each time, which falls evenly to zero.
std::vector<tool::WaypointParams> findArrivingPath(const std::vector<tool::WaypointParams>& path,
                                                   const ContactLoad::Arrival& arrival);

}  // namespace deformable_surface::simulation
