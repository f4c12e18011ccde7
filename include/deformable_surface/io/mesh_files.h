// Reads closed meshes for tools from mesh files. The only file that uses assimp.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/geometry/solid_params.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/tool/tool_params.h"

#include <string>
#include <vector>

namespace deformable_surface::io {

/// The closed mesh in a file (a path, package://PACKAGE/PATH or file:///PATH), all its parts together, each coordinate times the
/// scale. Throws InputError, naming the file, if the file cannot be read or is no closed mesh.
geometry::Solid readMeshFile(const std::string& file, const Vec3& scale, const FindPackage& find_package = {});

/// Reads the mesh files of the tools. Throws InputError.
void readMeshFiles(std::vector<tool::ToolParams>& tools, const FindPackage& find_package = {});

}  // namespace deformable_surface::io
