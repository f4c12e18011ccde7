// What accuracy targets save on scenes of other families than those on which the error estimate was fitted. The factors of the
// choice were fitted on seeds 1000 to 1037.
#pragma once

#include "sections.h"

namespace deformable_surface::benchmark {

/// Time of choosing and running, over set-up and run of all points once, with the largest error against these.
void reportVariedTargets(const Options& options, Report& report);

}  // namespace deformable_surface::benchmark
