// Loads a scene with the files that it names: parameters, meshes of its tools and its cloud. Beside the core, a program needs
// only this to run what `simulate` runs.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/simulation/scene_params.h"

#include <string>
#include <vector>

namespace deformable_surface::io {

/// The scene in a YAML file, changed by assignments as of setByPath(), with the meshes of its tools read. find_package: for
/// package://NAME/PATH in the scene; node::findPackage() asks ROS. Throws InputError with all problems of the parameters at once,
/// or with that of a mesh.
simulation::SceneParams loadScene(const std::string& file, const std::vector<std::string>& assignments = {},
                                  const FindPackage& find_package = {});

/// The cloud of the scene: its file or its generated shape. The filters of input.filter are not applied yet (filterCloud()).
/// Throws InputError.
cloud::PointCloud loadCloud(const simulation::SceneParams& params, const FindPackage& find_package = {});

}  // namespace deformable_surface::io
