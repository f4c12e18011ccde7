// What makes steps faster, in words for the user of a simulation that falls behind the clock.
#pragma once

#include "deformable_surface/simulation/simulation.h"

#include <string>

namespace deformable_surface::node {

/// Whether tools touch points of the cloud beside the simulation points (contact.cloud_points).
bool touchesCloudPoints(const simulation::Simulation& simulation);

/// What would have made the last step faster, with what changes the result least first.
std::string nameFaster(const simulation::SceneParams& params, const simulation::Statistics& last, bool touches_cloud_points);

}  // namespace deformable_surface::node
