// Contact wrenches of tools and pins as messages. The node and `simulate` share it.
#pragma once

#include "deformable_surface/ToolWrenchArray.h"
#include "deformable_surface/simulation/simulation.h"

#include <geometry_msgs/WrenchStamped.h>

#include <set>
#include <string>
#include <vector>

namespace deformable_surface::node {

/// Tools in their own frames, about their origins; pins in the frame of the header; both in the order of the reactions. silent:
/// ids of the silent tools.
ToolWrenchArray makeToolWrenches(const std_msgs::Header& header, const std::vector<simulation::ToolReaction>& reactions,
                                 const std::vector<simulation::PinReaction>& pins, const std::set<std::string>& silent = {});

/// The same for one tool in the surface's frame, that of the header, also about the tool's origin.
geometry_msgs::WrenchStamped makeToolWrench(const std_msgs::Header& header, const simulation::ToolReaction& reaction,
                                            const tool::Pose& pose);

}  // namespace deformable_surface::node
