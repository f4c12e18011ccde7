// Largest distance of a tool's surface from its origin. Contact skips points beyond it, and sleeping points within it wake.
#pragma once

#include "deformable_surface/tool/tool.h"

namespace deformable_surface::simulation {

/// Radius (m) of a ball about the tool's origin that holds its shape; infinite for a plane.
double findRadius(const geometry::Solid& shape);

/// Whether any of the points (n x 3) is within that ball at a time (s) at which the tool acts; for tools that attract, within
/// tool.reach of the ball.
bool isInReach(const tool::ToolParams& tool, double time, const Points& points);

}  // namespace deformable_surface::simulation
