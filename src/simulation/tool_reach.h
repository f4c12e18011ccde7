// How far a tool reaches from its own origin. A file of its own, because contact leaves out what is beyond, and what sleeps wakes
// within.
#pragma once

#include "deformable_surface/tool/tool.h"

namespace deformable_surface::simulation {

/// Radius (m) of a ball about the tool's origin that holds its shape; infinite for a plane.
double findRadius(const geometry::Solid& shape);

/// Whether any of the points (n x 3) is within that ball, and within tool.reach of it where the tool attracts, at a time (s) at
/// which it acts.
bool isInReach(const tool::ToolParams& tool, double time, const Points& points);

}  // namespace deformable_surface::simulation
