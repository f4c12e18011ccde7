// Reading of volumes: MetaImage files (.mha), which ITK, VTK, 3D Slicer and SimpleITK write. A reader of its own, because it is
// short and takes one kind of file alone: one that holds all its samples, not compressed.
#pragma once

#include "deformable_surface/io/point_files.h"
#include "deformable_surface/model/oriented_particles/guide_params.h"

#include <string>

namespace deformable_surface::io {

/// Reads a volume with three dimensions and one number per sample. scale: m per unit of length of the file. Throws InputError
/// with the file's name: what was found, what is accepted.
geometry::Volume readVolumeFile(const std::string& file, double scale, const FindPackage& find_package = {});

/// Reads the volume of a guide that names a file. Throws InputError if the iso-value is not between its least and largest value.
void readGuide(model::GuideParams& guide, const FindPackage& find_package = {});

}  // namespace deformable_surface::io
