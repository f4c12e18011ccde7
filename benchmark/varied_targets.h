// What accuracy targets save on scenes of other families than those on which the estimate was fitted.
#pragma once

#include "sections.h"

namespace deformable_surface::benchmark {

/// Time of choosing and running, over set-up and run of all points once, with the largest error against these.
void reportVariedTargets(const Options& options, Report& report);

}  // namespace deformable_surface::benchmark
