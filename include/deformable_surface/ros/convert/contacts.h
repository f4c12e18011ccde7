// Contacts of the surface with tools and itself, as a message. The node and `simulate` share it.
#pragma once

#include "deformable_surface/ContactArray.h"
#include "deformable_surface/simulation/simulation.h"

namespace deformable_surface::node {

/// In the frame of the header, which is the surface's.
ContactArray makeContacts(const std_msgs::Header& header, const std::vector<tool::ToolParams>& tools,
                          const std::vector<simulation::Contact>& contacts, const std::vector<simulation::SelfTouch>& touches);

}  // namespace deformable_surface::node
