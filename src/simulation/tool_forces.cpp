#include "tool_forces.h"

#include <algorithm>

namespace deformable_surface::simulation {
namespace {

// N, on a touched point.
Vec3 findForce(const LoadSet& loads, std::size_t body, double time, const model::State& state, const ContactLoad::Touch& touch) {
  return touch.force + loads.contact_damping.findForce(body, time, state, touch) +
         loads.friction.findForce(body, time, state, touch);
}

}  // namespace

void addReactions(const LoadSet& loads, double time, const model::State& state, std::vector<ToolReaction>& reactions) {
  const std::vector<ContactLoad::Body>& bodies = loads.contact.all();
  const auto& touches = loads.contact.findTouches(time, state);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const tool::ToolParams& tool = bodies[b].tool;
    const auto found = std::find_if(reactions.begin(), reactions.end(), [&](const ToolReaction& r) { return r.id == tool.id; });
    if (found == reactions.end()) continue;
    const tool::Pose pose = tool::interpolate(tool.path, time);
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const ContactLoad::Touch& touch : touches[b]) {
      const Vec3 on_point = findForce(loads, b, time, state, touch);
      force -= on_point;
      torque -= (touch.position - pose.position).cross(on_point);
      ++found->contacts;
      found->penetration = std::max(found->penetration, -touch.distance);
    }
    found->force += pose.orientation.conjugate() * force;
    found->torque += pose.orientation.conjugate() * torque;
  }
}

void appendContacts(const LoadSet& loads, double time, const model::State& state, const std::string& id, Index place,
                    std::vector<Contact>& contacts) {
  const std::vector<ContactLoad::Body>& bodies = loads.contact.all();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (bodies[b].tool.id != id) continue;
    for (const ContactLoad::Touch& touch : loads.contact.findTouches(time, state)[b])
      contacts.push_back({place, loads.contact.points().simulationPointOf(touch.point), touch.position, touch.normal,
                          -touch.distance, findForce(loads, b, time, state, touch)});
  }
}

}  // namespace deformable_surface::simulation
