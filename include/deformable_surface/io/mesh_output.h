// Writes triangles with normals for programs that draw them.
#pragma once

#include "deformable_surface/base/types.h"

#include <array>
#include <string>
#include <vector>

namespace deformable_surface::io {

/// Writes positions (n x 3, m), normals (n x 3, unit) and triangles (corners of 0 to n - 1) to an .obj file, with nine digits,
/// first under a temporary name (pending_file.h). Throws InputError if the name or the place is not accepted.
void writeMeshFile(const std::string& file, const Points& positions, const Points& normals,
                   const std::vector<std::array<Index, 3>>& triangles);

/// Throws InputError unless the extension is .obj.
void checkMeshFileName(const std::string& file);

}  // namespace deformable_surface::io
