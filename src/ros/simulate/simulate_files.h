// Checks the files of a run of `simulate`: problems are found before the run, not at its end.
#pragma once

#include "simulate_options.h"

#include "deformable_surface/simulation/scene_params.h"

#include <string>

namespace deformable_surface::node {

/// Throws InputError if a cloud could not be written to the file of the option.
void checkPointFile(const std::string& option, const std::string& file);
/// Throws InputError if no file of this name could be written; option: for the sentence.
void requireWritable(const std::string& option, const std::string& file);
/// A run must not overwrite its inputs, nor one output another: throws InputError if it would.
void checkFilesDiffer(const SimulateOptions& options, const simulation::SceneParams& params);

}  // namespace deformable_surface::node
