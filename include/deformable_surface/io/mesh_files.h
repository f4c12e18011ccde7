// Mesh files, and the meshes in them that tools are made of. The only file that names assimp.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/geometry/solid_params.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/tool/tool_params.h"

#include <string>
#include <vector>

namespace deformable_surface::io {

/// The closed mesh in a file (a path, package://PACKAGE/PATH or file:///PATH), all its parts together, each coordinate times the
/// scale. Throws InputError, naming the file, for what cannot be read or is no closed mesh.
geometry::Solid readMeshFile(const std::string& file, const Vec3& scale, const FindPackage& find_package = {});

/// Reads the files of the tools' meshes into them. Throws InputError.
void readMeshFiles(std::vector<tool::ToolParams>& tools, const FindPackage& find_package = {});

}  // namespace deformable_surface::io
