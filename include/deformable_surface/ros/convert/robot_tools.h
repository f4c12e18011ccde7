// Links of a robot as tools: from a URDF to the commands that add them, once at the start.
#pragma once

#include "deformable_surface/Tool.h"
#include "deformable_surface/tool/robot_params.h"

#include <string>
#include <vector>

namespace deformable_surface::node {

/// A solid tool for every piece of collision geometry of the links; it follows the frame of its link. The first of a link has
/// the link's name as its id, with '_' for characters that ids may not have; the next ones NAME_1, NAME_2. Spheres, boxes,
/// cylinders and closed meshes. Throws InputError for an invalid description, a link that it does not have, pieces that would
/// have the same id or one that is too long, and geometry that is not accepted.
std::vector<Tool> makeRobotTools(const std::string& urdf, const std::vector<tool::RobotLinkParams>& links);

/// The URDF in a file. Throws InputError.
std::string readDescription(const std::string& file);

}  // namespace deformable_surface::node
