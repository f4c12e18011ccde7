// Set-up of real scans. Apart from scale_section.cpp, because scans are read from files that are no part of the repository.
#pragma once

#include "sections.h"

namespace deformable_surface::benchmark {

/// Scans in the folder that DEFORMABLE_SURFACE_DATA names: set-up and a frame of each that is there.
void measureScans(const Options& options, Report& report);

}  // namespace deformable_surface::benchmark
