// Set-up of real scans. Separate from scale_section.cpp, because the scans are files outside the repository.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "sections.h"

#include <optional>
#include <string>

namespace deformable_surface::benchmark {

/// A scan in the folder DEFORMABLE_SURFACE_DATA; nothing if the file or its reader is missing.
std::optional<cloud::PointCloud> readScan(const std::string& name);
constexpr const char* kScansAreRead = "scans: DEFORMABLE_SURFACE_DATA names their folder, and libpcl-dev reads them";

/// Scans of that folder: set-up and a frame of each that is there.
void measureScans(const Options& options, Report& report);

}  // namespace deformable_surface::benchmark
