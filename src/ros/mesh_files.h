// Files that are named by a package, and the meshes in them that tools are made of. The only room that knows packages; the only
// file that names assimp.
#pragma once

#include "deformable_surface/geometry/solid_params.h"
#include "deformable_surface/tool/tool_params.h"

#include <string>
#include <vector>

namespace deformable_surface::node {

/// The folder of a package by ROS, else of this one beside the program in an install space without a ROS environment. Throws
/// InputError.
std::string findPackage(const std::string& package);

/// The closed mesh in a file (a path, package://PACKAGE/PATH or file:///PATH), all its parts together, each coordinate times the
/// scale. Throws InputError, naming the file, for what cannot be read or is no closed mesh.
geometry::Solid readMeshFile(const std::string& file, const Vec3& scale);

/// Reads the files of the tools' meshes into them. Throws InputError.
void readMeshFiles(std::vector<tool::ToolParams>& tools);

}  // namespace deformable_surface::node
