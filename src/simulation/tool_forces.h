// What contact does to tools and to the points that they touch: the sum of the springs, their damping and friction.
#pragma once

#include "deformable_surface/simulation/tool_reaction.h"

#include "load_set.h"

namespace deformable_surface::simulation {

/// Adds the contact wrench of each solid and attracting tool to the reaction of its id.
void addReactions(const LoadSet& loads, double time, const model::State& state, std::vector<ToolReaction>& reactions);
/// Appends the contacts of the tool of that id, if it is a solid or attracting one. place: of the tool, for Contact::tool.
void appendContacts(const LoadSet& loads, double time, const model::State& state, const std::string& id, Index place,
                    std::vector<Contact>& contacts);

}  // namespace deformable_surface::simulation
