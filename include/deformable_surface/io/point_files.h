// Reads and writes point files: PCD and PLY (read through PCL) and plain text. Within the core only this room uses PCL: its build
// time and alignment rules stay here.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"

#include <functional>
#include <string>
#include <vector>

namespace deformable_surface::io {

/// Gives the folder of a ROS package; throws InputError if there is none.
using FindPackage = std::function<std::string(const std::string& package)>;

/// The path of a file whose name may begin with package://NAME/. Throws InputError if the package is not found.
std::string findPointFile(const std::string& file, const FindPackage& find_package);

/// Reads a cloud: .pcd (ascii, binary, binary_compressed), .ply (ascii or binary; faces are left out), .obj and .off (their
/// vertices) or .xyz (lines of x y z or of x y z nx ny nz and more). file may begin with package://NAME/. Positions are
/// multiplied by scale (m per file unit). Rows that are not finite stay. Fields beyond position and normal become extra fields; a
/// PLY's colours become one packed field, rgb or rgba. Throws InputError naming the file: missing, of another kind, broken,
/// shorter than its header says (found before memory is taken), without x, y, z, without points, or with more than max_points.
cloud::PointCloud readPointFile(const std::string& file, double scale, Index max_points, const FindPackage& find_package = {});

/// Writes x y z, the normals and the displacement (n, or empty) as float32, and the extra fields, to a binary .ply or .pcd, first
/// under a temporary name (pending_file.h). Width and height are kept in a .pcd. An extra field called displacement is
/// replaced by the displacement. Throws InputError if the name or the place is not accepted, or normals, displacement and fields
/// are not those of as many points.
void writePointFile(const std::string& file, const cloud::PointCloud& cloud, const std::vector<float>& displacement = {});

/// Throws InputError unless writePointFile() knows the extension. For options whose file is written after a long run.
void checkPointFileName(const std::string& file);

}  // namespace deformable_surface::io
