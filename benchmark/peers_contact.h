// A sheet on a sphere, and folded on itself, beside Bullet's deformable bodies. Apart from the other peers, because contact has
// measures of its own.
#pragma once

#include "report.h"

namespace deformable_surface::benchmark {

/// Processor time, crossings, penetration and stretch.
void compareContact(Report& report);

}  // namespace deformable_surface::benchmark
