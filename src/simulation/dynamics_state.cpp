#include "dynamics_state.h"

namespace deformable_surface::simulation {
namespace {

template <class T>
std::size_t bytesOf(const std::vector<T>& items) {
  return items.size() * sizeof(T);
}
template <class T>
std::size_t bytesInside(const T&) {
  return 0;
}
std::size_t bytesInside(const tool::ToolParams& tool) { return bytesOf(tool.path); }
std::size_t bytesInside(const NamedForces::Named& force) {
  return bytesOf(force.points) + bytesOf(force.shares) + (force.carriers ? bytesOf(*force.carriers) : 0);
}
std::size_t bytesInside(const ContactLoad::Body& body) {
  return bytesInside(body.tool) + bytesOf(body.passed) + bytesOf(body.pressed);
}
std::size_t bytesInside(const Grips::Grip& grip) {
  return bytesInside(grip.tool) + bytesOf(grip.points) + bytesOf(grip.places) + bytesOf(grip.edges);
}
std::size_t bytesInside(const std::shared_ptr<const Evolution::Memory>& evolution) { return evolution ? evolution->bytes() : 0; }
std::size_t bytesInside(const SelfContactLoads::Memory& contact) { return contact.proven ? contact.proven->bytes() : 0; }
std::size_t bytesInside(const Activity::Memory& activity) { return bytesOf(activity.quiet) + bytesOf(activity.moves); }
std::size_t bytesInside(const model::State& s) {
  return bytesOf(s.positions) + bytesOf(s.velocities) + bytesOf(s.orientations) + bytesOf(s.spins) + bytesOf(s.traits) +
         bytesOf(s.plastic) + bytesOf(s.friction) + bytesOf(s.self_friction) + bytesOf(s.escaped);
}
template <class T>
std::size_t bytesInside(const std::vector<T>& items) {
  std::size_t sum = bytesOf(items);
  for (const T& item : items) sum += bytesInside(item);
  return sum;
}
template <class... Parts>
std::size_t sumInside(const Parts&... parts) {
  return (bytesInside(parts) + ...);
}

}  // namespace

// The structured bindings name every member: a new member does not compile before it is counted here.
std::size_t DynamicsState::bytes() const {
  const auto& [steps, forces, watched, activity, march, part_march, has_part] = waiting;
  const auto& [points, pinned, pinned_turns, clamp_edges, membrane_share, contact_rate, followed] = motion;
  const auto& [integrator, grips, bodies, evolution, tracked, self_contact, untangling] = holding;
  const auto& [tools, values, gravity, damping, physics] = settings;
  return sizeof(DynamicsState) + sumInside(steps, forces, watched, activity, march, part_march, has_part) +
         sumInside(points, pinned, pinned_turns, clamp_edges, membrane_share, contact_rate, followed) +
         sumInside(integrator, grips, bodies, evolution, tracked, self_contact, untangling) +
         sumInside(tools, values, gravity, damping, physics);
}

}  // namespace deformable_surface::simulation
