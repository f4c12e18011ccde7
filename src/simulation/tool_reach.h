// Largest distance of a tool's surface from its origin, and its width. Contact skips points beyond the distance, and sleeping
// points within it wake. Narrow tools pass between points.
#pragma once

#include "deformable_surface/tool/tool.h"

namespace deformable_surface::simulation {

/// Radius (m) of a ball about the tool's origin that holds its shape; infinite for a plane.
double findRadius(const geometry::Solid& shape);

/// The width (m) of what passes through a surface with the longest extent ahead: the second of the three extents.
double findWidth(const geometry::Solid& shape);

/// Whether any of the points (n x 3) is within that ball at a time (s) at which the tool acts; for tools that attract, within
/// tool.reach of the ball.
bool isInReach(const tool::ToolParams& tool, double time, const Points& points);

}  // namespace deformable_surface::simulation
