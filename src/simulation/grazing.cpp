#include "grazing.h"

#include "tool_reach.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kOpposite = -0.9;  // cosine of normals that press a point from both sides
constexpr double kAlong = 2.0;      // least speed along the surface over that towards it: slower ones close like jaws

bool isInReach(const tool::ToolParams& tool, const tool::Pose& pose, const Vec3& place, double thickness) {
  const double reach = findRadius(tool.shape) + thickness;
  return (place - pose.position).squaredNorm() < reach * reach;
}

}  // namespace

Grazing findGrazing(const ContactLoad& contact, double time, const model::State& state, double thickness) {
  const std::vector<ContactLoad::Body>& bodies = contact.all();
  const auto& touches = contact.findTouches(time, state);
  for (std::size_t s = 0; bodies.size() > 1 && s < bodies.size(); ++s) {
    const tool::ToolParams& slider = bodies[s].tool;
    if (slider.mode != tool::Mode::kSolid || !bodies[s].acts.value_or(false)) continue;
    const tool::Motion motion = tool::findMotion(slider.path, time);
    if (motion.velocity.isZero(0.0) && motion.angular_velocity.isZero(0.0)) continue;
    if (!touches[s].empty()) continue;
    const tool::Pose pose = tool::interpolate(slider.path, time);
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (b == s || bodies[b].tool.mode != tool::Mode::kSolid) continue;
      for (const ContactLoad::Touch& touch : touches[b]) {
        if (contact.points().isBetween(touch.point) || !isInReach(slider, pose, touch.position, thickness)) continue;
        const geometry::SignedDistance d = tool::findSignedDistance(slider.shape, pose, touch.position, thickness);
        if (!(d.distance >= 0.0 && d.distance < thickness && d.normal.dot(touch.normal) < kOpposite)) continue;
        const Vec3 sliding = motion.velocityAt(touch.position) - state.velocities[touch.point];
        const double towards = std::abs(sliding.dot(d.normal));
        if (!(sliding.norm() > kAlong * towards)) continue;
        return {&slider, &bodies[b].tool, d.distance};
      }
    }
  }
  return {};
}

}  // namespace deformable_surface::simulation
