// The files of a run of `simulate`: what is wrong with them is found before the run, not at its end.
#pragma once

#include "simulate_options.h"

#include "deformable_surface/simulation/scene_params.h"

#include <string>

namespace deformable_surface::node {

/// Throws InputError if no cloud could be written to the file of the option.
void checkPointFile(const std::string& option, const std::string& file);
/// A run must not destroy what it is made from, nor one output another: throws InputError if it would.
void checkFilesDiffer(const SimulateOptions& options, const simulation::SceneParams& params);

}  // namespace deformable_surface::node
