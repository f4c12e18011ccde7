// What the surface does to tools and pins, asked of a simulation. Apart from its commands, because nothing here changes anything.
#include "simulation_impl.h"

#include <algorithm>

namespace deformable_surface::simulation {

std::vector<ToolReaction> Simulation::toolReactions() const {
  std::vector<ToolReaction> reactions(impl_->tools.size());
  for (std::size_t t = 0; t < reactions.size(); ++t) reactions[t].id = impl_->tools[t].id;
  impl_->contact.addReactions(impl_->time(), impl_->state, reactions);
  if (impl_->grips.isEmpty()) return reactions;
  impl_->system.computeForcesOnAll(impl_->time(), impl_->state, impl_->forces_on_all);
  impl_->grips.addReactions(impl_->time(), impl_->state, impl_->forces_on_all, reactions);
  return reactions;
}

std::vector<Contact> Simulation::contacts() const {
  std::vector<Contact> contacts;
  const std::vector<tool::ToolParams>& tools = impl_->tools;
  for (Index t = 0; t < static_cast<Index>(tools.size()); ++t)
    impl_->contact.appendContacts(impl_->time(), impl_->state, tools[t].id, t, contacts);
  return contacts;
}

std::vector<PinReaction> Simulation::pinReactions() const {
  const std::vector<PinParams>& pins = impl_->params.pins;
  std::vector<PinReaction> reactions(pins.size() + 1);
  for (std::size_t p = 0; p < pins.size(); ++p) reactions[p].id = "pins[" + std::to_string(p) + "]";
  reactions.back().id = kOtherPins;
  const State& state = impl_->state;
  impl_->system.computeForcesOnAll(impl_->time(), state, impl_->forces_on_all);
  for (Index i = 0; i < state.size(); ++i) {
    if (!impl_->pinned[i]) continue;
    const Index first = state.traits.empty() ? i : state.traits[i].id;  // its place at rest
    const bool is_first = first < static_cast<Index>(impl_->rest.points.size());
    PinReaction& reaction = reactions[is_first ? impl_->findPin(first) : pins.size()];
    reaction.force += impl_->forces_on_all[i];
    reaction.torque += state.positions[i].cross(impl_->forces_on_all[i]);
    reaction.points += impl_->pinned[i] == kInPin;
  }
  if (reactions.back().points == 0) reactions.pop_back();
  return reactions;
}

}  // namespace deformable_surface::simulation
