// Set-up of real scans. Apart from scale_section.cpp, because scans are read from files that are no part of the repository.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "sections.h"

#include <optional>
#include <string>

namespace deformable_surface::benchmark {

/// A scan in the folder that DEFORMABLE_SURFACE_DATA names; nothing where the file or what reads it is absent.
std::optional<cloud::PointCloud> readScan(const std::string& name);
constexpr const char* kScansAreRead = "scans: DEFORMABLE_SURFACE_DATA names their folder, and libpcl-dev reads them";

/// Scans of that folder: set-up and a frame of each that is there.
void measureScans(const Options& options, Report& report);

}  // namespace deformable_surface::benchmark
